import math

import numpy as np
import pytest

from sim import light
from sim.errors import SceneConfigError


def test_the_sun_stands_where_its_angles_say() -> None:
    sun = light.sun_direction()
    assert np.linalg.norm(sun) == pytest.approx(1)
    assert math.asin(sun[2]) == pytest.approx(light.SUN_ELEVATION_RAD)
    assert sun[1] < 0  # on the camera's side


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
