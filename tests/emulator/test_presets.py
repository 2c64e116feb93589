from dataclasses import replace
from typing import Any, get_args

import numpy as np
import pytest

from emulator import Davis346, SensorConfig, SensorConfigError, preset
from emulator.presets import PresetName
from tests.emulator.scenes import flat, luminance_for, moving_texture, run


def test_the_default_is_the_davis346() -> None:
    assert preset("davis346") == SensorConfig()


@pytest.mark.parametrize("name", get_args(PresetName))
def test_every_preset_sees_motion(name: Any) -> None:
    config = replace(preset(name), width=16, height=12)
    events, _ = run(Davis346(config, seed=1), moving_texture(60))
    assert events["p"].any()
    assert not events["p"].all()


@pytest.mark.parametrize(
    ("name", "shape"), [("davis240", (240, 180)), ("dvs128", (128, 128)), ("ideal", (346, 260))]
)
def test_presets_have_the_size_of_their_sensor(name: Any, shape: tuple[int, int]) -> None:
    assert (preset(name).width, preset(name).height) == shape


def test_v2e_noisy_has_five_shot_noise_events_a_second_in_the_dark() -> None:
    config = replace(preset("v2e_noisy"), width=64, height=48, leak_hz=0.0)
    frame = flat(luminance_for(0.1, config), config)
    events, _ = run(Davis346(config, seed=1), ((t, frame) for t in range(0, 1_000_001, 20_000)))
    assert events.size / 3072 == pytest.approx(5.0, rel=0.05)


def test_v2e_clean_is_silent_on_a_still_scene() -> None:
    clean = preset("v2e_clean")
    aps = replace(clean.aps, period_min_us=10_000_000)
    config = replace(clean, width=64, height=48, aps=aps)
    frame = flat(1.0, config) * np.random.default_rng(1).random((48, 64), np.float32)
    events, _ = run(Davis346(config, seed=1), [(0, frame), (10**6, frame), (10**9, frame)])
    assert events.size == 0


def test_another_name_is_refused() -> None:
    with pytest.raises(SensorConfigError, match="the preset is 'davis640'; allowed is one of dav"):
        preset("davis640")  # type: ignore[arg-type]
