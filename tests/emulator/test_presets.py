import math
from dataclasses import replace
from typing import Any, get_args

import numpy as np
import pytest

from emulator import SensorConfig, SensorConfigError, preset
from emulator.presets import PresetName
from tests.emulator.stimuli import luminance_for_lux, moving_texture, run_sensor, uniform_frame


def test_the_default_is_the_davis346() -> None:
    assert preset("davis346") == SensorConfig()


@pytest.mark.parametrize("name", get_args(PresetName))
def test_every_preset_responds_to_motion(name: Any) -> None:
    config = replace(preset(name), width=16, height=12)
    events, _ = run_sensor(config, moving_texture(60))
    assert events["p"].any()
    assert not events["p"].all()


@pytest.mark.parametrize(
    ("name", "shape", "degrees"),
    [
        ("davis240", (240, 180), 40.6),
        ("dvs128", (128, 128), 46.2),
        ("atis", (304, 240), 74.5),
        ("dvxplorer", (640, 480), 51.3),
        ("gen31", (640, 480), 77.3),
        ("imx636", (1280, 720), 54.8),
        ("ideal", (346, 260), 56.2),
    ],
)
def test_presets_have_the_size_and_field_of_view_of_their_sensor(
    name: Any, shape: tuple[int, int], degrees: float
) -> None:
    config = preset(name)
    half_angle = math.atan(config.width / 2 / config.focal_length_px)
    assert (config.width, config.height) == shape
    assert 2.0 * math.degrees(half_angle) == pytest.approx(degrees, abs=0.06)


def test_v2e_noisy_has_5_hz_of_shot_noise_in_dim_light() -> None:
    config = replace(preset("v2e_noisy"), width=128, height=96, leak_hz=0.0)
    frame = uniform_frame(luminance_for_lux(1.0, config), config)
    events, _ = run_sensor(config, ((t, frame) for t in range(0, 1_000_001, 20_000)))
    assert events.size / 12288 == pytest.approx(5.0, rel=0.05)


def test_the_former_default_has_nowhere_more_noise_than_it_had_in_the_dark() -> None:
    former = preset("davis346_2026_11")
    config = replace(
        former, width=64, height=48, leak_hz=0.0, leak_hz_per_lux=0.0, hot_fraction=0.0
    )

    def rate_hz(chip_lux: float) -> float:
        frame = uniform_frame(luminance_for_lux(chip_lux, config), config)
        events, _ = run_sensor(config, ((t, frame) for t in range(0, 4_000_001, 20_000)))
        return float(events.size) / (4 * 64 * 48)

    assert 5.0 < rate_hz(29.0) < 12.0  # σ falls from 30 lux on
    assert rate_hz(2.2) < 3.0
    assert rate_hz(100.0) < 1.0


def test_v2e_clean_gives_no_events_of_a_static_scene() -> None:
    clean = preset("v2e_clean")
    aps = replace(clean.aps, period_min_us=10_000_000)
    config = replace(clean, width=64, height=48, aps=aps)
    frame = uniform_frame(1.0, config) * np.random.default_rng(1).random((48, 64), np.float32)
    events, _ = run_sensor(config, [(0, frame), (10**6, frame), (10**9, frame)])
    assert events.size == 0


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(
        SensorConfigError, match=r"the preset is 'davis640'\. Allowed is one of dav"
    ):
        preset("davis640")  # type: ignore[arg-type]
