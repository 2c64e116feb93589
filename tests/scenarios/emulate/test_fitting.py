"""Pictures of any size on the sensor."""

import numpy as np
import pytest

from emulator import FrameError
from scenarios.emulate.fitting import light_on


def test_the_middle_fills_the_sensor_in_its_proportions() -> None:
    picture = np.zeros((200, 400), np.uint8)
    picture[50:150, 150:250] = 255  # a square in the middle
    light = light_on(picture, size=(100, 100), white_cd_m2=50.0, transfer="linear")
    assert light.shape == (100, 100)
    assert light.dtype == np.float32
    assert light[25:75, 25:75] == pytest.approx(50.0)
    light[25:75, 25:75] = 0
    assert light == pytest.approx(0.0)


def test_a_small_picture_grows() -> None:
    light = light_on(
        np.full((10, 30, 3), 255, np.uint8), size=(64, 48), white_cd_m2=9.0, transfer="srgb"
    )
    assert light.shape == (48, 64)
    assert light == pytest.approx(9.0)


def test_light_is_averaged_not_levels() -> None:
    stripes = np.zeros((100, 100), np.uint8)
    stripes[::2] = 255
    light = light_on(stripes, size=(50, 50), white_cd_m2=100.0, transfer="srgb")
    assert light == pytest.approx(50.0)


def test_floats_are_light_as_they_are() -> None:
    light = light_on(np.full((5, 5), 3.25), size=(5, 5), white_cd_m2=1.0, transfer="srgb")
    assert np.all(light == 3.25)


def test_a_white_that_is_none_is_refused() -> None:
    with pytest.raises(FrameError, match="white_cd_m2 is -1"):
        light_on(np.zeros((5, 5), np.uint8), size=(5, 5), white_cd_m2=-1.0, transfer="srgb")
