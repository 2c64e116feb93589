import math

import numpy as np
import pytest

from sim import CrossingConfig, Lighting
from sim.errors import SceneConfigError
from sim.scene import lighting as light
from sim.scene.scene import build_spec


@pytest.mark.parametrize(
    ("azimuth_deg", "elevation_deg", "expected"),
    [(0, 0, [0, 1, 0]), (90, 0, [1, 0, 0]), (-90, 45, [-1, 0, 1]), (180, 0, [0, -1, 0])],
)
def test_the_sun_direction_follows_its_angles(
    azimuth_deg: float, elevation_deg: float, expected: list[float]
) -> None:
    sun = light.sun_direction(azimuth_deg, elevation_deg)
    assert sun == pytest.approx(np.array(expected) / np.linalg.norm(expected))


def test_by_default_the_sun_stands_behind_the_cameras_left_shoulder() -> None:
    config = CrossingConfig()
    sun = light.sun_direction(config.sun_azimuth_deg, config.sun_elevation_deg)
    assert sun[0] < 0
    assert sun[1] < 0
    assert math.asin(sun[2]) == pytest.approx(math.radians(config.sun_elevation_deg))


def test_a_lamp_overhead_gives_candela_over_height_squared() -> None:
    assert light.unit_illuminance(np.array([[0.0, 0.0, 5.0]])) == pytest.approx(1 / 25)


def test_a_lamp_outside_its_full_cone_does_not_count() -> None:
    assert light.unit_illuminance(np.array([[60.0, 0.0, 5.0]])) == 0


def test_luminance_of_white_is_one_and_green_counts_most() -> None:
    assert light.relative_luminance([1, 1, 1, 1]) == pytest.approx(1)
    assert light.relative_luminance([0, 1, 0, 1]) > 0.7


def test_a_lamp_that_lights_the_origin_with_its_rim_is_refused() -> None:
    with pytest.raises(SceneConfigError, match="rim"):
        light.unit_illuminance(np.array([[10.0, 0.0, 5.0]]))


@pytest.mark.parametrize("rate_hz", [100, 120])
def test_flicker_keeps_the_mean_and_has_the_configured_depth(rate_hz: int) -> None:
    flicker = light.Flicker(rate_hz, 0.3)
    times_s = np.arange(0, 1, 1e-4) + 0.37
    factors = np.array([flicker.factor(t_s) for t_s in times_s])
    assert factors.mean() == pytest.approx(1, abs=1e-3)
    most, least = factors.max(), factors.min()
    assert (most - least) / (most + least) == pytest.approx(0.3, rel=1e-2)
    crossings = np.count_nonzero(np.diff(np.sign(factors - 1)))
    assert crossings == pytest.approx(2 * rate_hz, abs=2)


@pytest.mark.parametrize(("lux", "sky_lux"), [(300.0, 290.0), (50.0, 40.0), (8.0, 4.0)])
def test_at_dusk_lamps_and_sky_add_up_to_the_illuminance(lux: float, sky_lux: float) -> None:
    model = build_spec(CrossingConfig(lighting=Lighting.DUSK, illuminance_lux=lux)).compile()
    sky_cd_m2 = float(model.light_intensity[model.light("sky").id])
    assert sky_cd_m2 * math.pi == pytest.approx(sky_lux)
    lamps = [k for k in range(model.nlight) if "street" in model.light(k).name]
    candela = model.light_intensity[lamps[0]]
    positions = np.array([model.light_pos[k] for k in lamps])
    assert candela * light.unit_illuminance(positions) == pytest.approx(lux - sky_lux, rel=1e-4)


def test_a_dipped_beam_lights_nothing_above_its_lamp() -> None:
    for dip, cutoff_deg in (
        (light.BEAM_CENTRE_DIP, light.BEAM_CENTRE_CUTOFF_DEG),
        (light.BEAM_WIDE_DIP, light.BEAM_WIDE_CUTOFF_DEG),
    ):
        assert math.degrees(math.atan(dip)) > cutoff_deg
