"""Leak and hot pixels of sensors without any other noise."""

from dataclasses import replace

import numpy as np
import pytest

from emulator import SensorConfig
from emulator.noise.leak import TAIL_FACTOR, draw_leak_factors
from flybench.events import Cause
from tests.emulator.stimuli import intervals_us, luminance_for_lux, run_sensor, uniform_frame


def clean_config(**changes: object) -> SensorConfig:
    """Return a sensor of 3072 pixels without noise, except for the given changes."""
    config = SensorConfig.noise_free(width=64, height=48)
    config = replace(config, theta_mismatch=0.0, leak_spread=0.0, leak_tail_fraction=0.0)
    return replace(config, refractory_us=3, **changes)  # type: ignore[arg-type]


def static_scene(config: SensorConfig, lux: float, *, seconds: float, step_us: int, seed: int = 3):  # type: ignore[no-untyped-def]
    frame = uniform_frame(luminance_for_lux(lux, config), config)
    times = range(0, round(seconds * 1e6) + 1, step_us)
    return run_sensor(config, ((t, frame) for t in times), seed=seed)


def test_leak_events_are_on_at_the_given_rate_with_uniform_phases() -> None:
    events, causes = static_scene(clean_config(leak_hz=1.0), 100.0, seconds=2.0, step_us=20_000)
    assert np.all(causes == Cause.LEAK)
    assert events["p"].all()
    assert events.size == pytest.approx(2.0 * 3072, rel=0.01)
    phases = np.histogram(events["t"][events["t"] <= 1_000_000], 10, (0, 1_000_000))[0]
    assert phases.min() > 0.75 * 307
    gaps = intervals_us(events)
    assert np.all(np.abs(gaps - 1_000_000) <= 20)


def test_leak_grows_with_illuminance() -> None:
    config = clean_config(leak_hz=0.1, leak_hz_per_lux=2.4e-5)
    events, _ = static_scene(config, 100_000.0, seconds=1.0, step_us=20_000)
    assert events.size == pytest.approx(2.5 * 3072, rel=0.02)


def test_only_hot_pixels_fire_and_at_their_rates() -> None:
    events, causes = static_scene(clean_config(hot_fraction=0.01), 100.0, seconds=2.0, step_us=5000)
    assert np.all(causes == Cause.HOT)
    pixels, counts = np.unique(events["y"].astype(int) * 64 + events["x"], return_counts=True)
    assert 10 <= pixels.size <= 60
    assert counts.mean() / 2.0 == pytest.approx(50.5, rel=0.1)


def test_leaks_have_the_stated_spread_and_tail() -> None:
    factors = np.log(draw_leak_factors(SensorConfig(), np.random.default_rng(1)))
    plain = draw_leak_factors(
        SensorConfig(leak_spread=0.0, leak_tail_fraction=0.0), np.random.default_rng(1)
    )
    only = SensorConfig(leak_tail_fraction=1.0)
    tail = np.log(draw_leak_factors(only, np.random.default_rng(1)))
    assert np.all(plain == 1.0)
    assert np.median(tail) == pytest.approx(np.log(TAIL_FACTOR), abs=0.02)
    assert tail.std() == pytest.approx(1.4, rel=0.02)
    assert np.median(factors) == pytest.approx(0.03, abs=0.02)
    assert np.mean(factors > np.log(20.0)) == pytest.approx(0.1 * 0.0584, rel=0.15)
