"""The optical bench: illuminance, time constants and per-pixel counts."""

import numpy as np
import pytest

from emulator import SensorConfig
from emulator.characterisation.bench import (
    bench_sensor,
    chip_luminance,
    chip_lux_per_scene_lux,
    event_counts,
    events_between,
    first_times_us,
    lux_label,
    scene_luminance,
    static_samples,
    time_constant_us,
    uniform_frame,
)
from flybench.events import EVENT_DTYPE

CONFIG = SensorConfig(f_number=1.4, transmission=0.9, follower_hz=0.0)


def test_illuminance_on_the_chip_and_on_the_scene_agree() -> None:
    assert chip_lux_per_scene_lux(CONFIG) == pytest.approx(0.18 * 0.9 / (4 * 1.4**2))
    on_chip = chip_luminance(CONFIG, 1000.0 * chip_lux_per_scene_lux(CONFIG))
    assert on_chip == pytest.approx(scene_luminance(1000.0), rel=1e-6)


def test_the_time_constant_falls_with_illuminance_to_a_limit() -> None:
    assert time_constant_us(CONFIG, 0.99) == pytest.approx(1591.5, rel=1e-3)
    assert time_constant_us(CONFIG, 1e4) == pytest.approx(53.05, rel=1e-3)
    assert time_constant_us(SensorConfig.ideal(), 1e4) == 1.0
    assert time_constant_us(SensorConfig(bandwidth_limit_hz=1e-3, follower_hz=0.0), 1e4) == 60e6
    slow = SensorConfig(follower_hz=300.0)
    assert time_constant_us(slow, 1e4) == pytest.approx(53.05 + 530.5, rel=1e-3)


def test_events_are_counted_and_timed_per_pixel() -> None:
    events = np.array([(5, 1, 0, 1), (7, 1, 0, 0), (9, 0, 2, 1)], EVENT_DTYPE)
    assert event_counts(events, (3, 2)).tolist() == [[0, 2], [0, 0], [1, 0]]
    first = first_times_us(events, (3, 2))
    assert first[0, 1] == 5
    assert first[2, 0] == 9
    assert np.isnan(first).sum() == 4
    assert events_between(events, 5, 7)["t"].tolist() == [7]


def test_a_bench_sensor_takes_frames_rarely() -> None:
    small = bench_sensor(CONFIG, width=3, height=2)
    assert (small.width, small.height) == (3, 2)
    assert small.aps.period_min_us == 10_000_000
    samples = static_samples(uniform_frame(small, 3.0), duration_s=2.0)
    assert [t_us for t_us, _ in samples] == [0, 1_000_000, 2_000_000]
    assert samples[0][1].shape == (2, 3)


def test_large_illuminances_are_labelled_in_klux() -> None:
    assert [lux_label(lux) for lux in (0.1, 100.0, 1e5)] == ["0.1 lux", "100 lux", "100 klux"]
