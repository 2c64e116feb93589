"""The cache key changes with everything that determines luminance."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sim import (
    Crossing,
    CrossingConfig,
    Distractors,
    Intrinsics,
    Lighting,
    Pose,
    Quality,
    RelativeDirection,
)
from sim.cache import key as luminance_key
from sim.render.vulkan import VulkanDevice

TIMES_US = [0, 1000, 2500]
CONFIG = CrossingConfig()
SAME = RelativeDirection.SAME


@pytest.fixture(scope="module")
def model() -> Any:
    return Crossing(CONFIG).scene.model


def key(model: Any, config: CrossingConfig = CONFIG, **options: Any) -> str:
    others: dict[str, Any] = {"lens": Intrinsics(), "times_us": TIMES_US} | options
    return luminance_key.luminance_key(config, model, **others)


def test_equal_configurations_have_equal_keys_of_64_hexadecimal_digits(model: Any) -> None:
    assert len(key(model)) == 64
    assert int(key(model), 16) > 0
    assert key(
        Crossing(CrossingConfig(distance_m=6.89, illuminance_lux=30_000)).scene.model
    ) == key(model)


@pytest.mark.parametrize(
    "changed",
    [
        {"omega_rad_s": 1.62},
        {"lighting": Lighting.DUSK},
        {"paint_reflectance": 0.5},
        {"step_px": 0.4},
        {"keyframe_px": 16.0},
        {"supersample": 2},
        {"distractors": Distractors(shake_rms_deg=0.1)},
        {"distractors": Distractors(seed=1)},
    ],
)
def test_any_change_of_the_configuration_changes_the_key(
    model: Any, changed: dict[str, Any]
) -> None:
    assert key(model, replace(CONFIG, **changed)) != key(model)


def test_what_is_rendered_makes_the_key_of_a_quality(model: Any) -> None:
    config = replace(CONFIG, step_px=1.0, keyframe_px=32.0)
    draft = key(model, replace(config, quality=Quality.DRAFT))
    assert draft == key(model, replace(config, step_px=1.6, keyframe_px=64.0))
    assert draft != key(model, config)
    assert key(model, replace(config, quality=Quality.FINE)) == key(model, config)


def test_lens_and_times_change_the_key(model: Any) -> None:
    others = {
        key(model, lens=Intrinsics(focal_px=300.0)),
        key(model, lens=Intrinsics(width=345)),
        key(model, times_us=TIMES_US[:2]),
        key(model, times_us=[0, 1001, 2500]),
    }
    assert len(others | {key(model)}) == 5


def test_the_scene_changes_the_key_and_rendering_does_not() -> None:
    crossing = Crossing(replace(CONFIG, step_px=8.0, supersample=1))
    before = key(crossing.scene.model)
    list(crossing.samples([0, crossing.duration_us // 2]))
    assert key(crossing.scene.model) == before
    crossing.scene.model.mat_rgba[3, 0] *= 0.5
    assert key(crossing.scene.model) != before


def test_libraries_devices_and_sources_change_the_key(
    model: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    keys = {key(model)}
    monkeypatch.setattr("sim.cache.key.mujoco.__version__", "4.0.1")
    keys.add(key(model))
    monkeypatch.setattr("sim.cache.key.np.__version__", "9")
    keys.add(key(model))
    monkeypatch.setattr(luminance_key, "vulkan_devices", lambda: [VulkanDevice("a", "b", False)])
    keys.add(key(model))
    monkeypatch.setattr(luminance_key, "sources_digest", lambda *_: "0")
    keys.add(key(model))
    assert len(keys) == 5


def background(**changed: Any) -> str:
    """Return the key of the background of a changed configuration at the same pose and lens."""
    config, lens = replace(CONFIG, **changed), Intrinsics()
    return luminance_key.background_key(config, lens, Pose(np.zeros(3)), supersample=3)


@pytest.mark.parametrize(
    "changed",
    [
        {"omega_rad_s": 1.2, "paint_reflectance": 0.1, "vehicle": "van", "step_px": 1.0},
        {"distractors": Distractors(pedestrian=SAME, far_vehicle=SAME, shake_rms_deg=0.1)},
    ],
)
def test_moving_objects_share_a_background(changed: dict[str, Any]) -> None:
    assert background(**changed) == background()


@pytest.mark.parametrize(
    "changed",
    [
        {"lighting": Lighting.DUSK, "illuminance_lux": 30_000.0},
        {"illuminance_lux": 29_000.0},
        {"sun_elevation_deg": 50.0},
        {"street_seed": 1},
        {"distractors": Distractors(wind_grade=1)},
        {"distractors": Distractors(flicker_hz=100)},
    ],
)
def test_another_street_or_light_has_another_background(changed: dict[str, Any]) -> None:
    assert background(**changed) != background()


def test_every_parameter_either_changes_the_background_or_belongs_to_moving_objects() -> None:
    """A new parameter counts, unless it is listed."""
    known = set(CONFIG.resolved()) | set(CONFIG.resolved()["distractors"])
    assert known >= luminance_key._OF_MOVERS


def test_camera_and_rendering_change_the_key_of_the_background() -> None:
    def of(lens: Intrinsics, x_m: float, **options: int) -> str:
        pose = Pose(np.array([x_m, 0.0, 0.0]))
        return luminance_key.background_key(CONFIG, lens, pose, **options)

    keys = {
        of(Intrinsics(), 0.0, supersample=3),
        of(Intrinsics(width=345), 0.0, supersample=3),
        of(Intrinsics(), 1.0, supersample=3),
        of(Intrinsics(), 0.0, supersample=2),
    }
    assert len(keys) == 4
