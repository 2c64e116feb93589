"""Luminance of pictures of any size on the sensor."""

import numpy as np
import pytest

from emulator import FrameError
from scenarios.emulate.picture_luminance import sensor_luminance


def test_the_middle_of_the_picture_fills_the_sensor() -> None:
    picture = np.zeros((200, 400), np.uint8)
    picture[50:150, 150:250] = 255  # a square in the middle
    luminance = sensor_luminance(picture, size=(100, 100), white_cd_m2=50.0, transfer="linear")
    assert luminance.shape == (100, 100)
    assert luminance.dtype == np.float32
    assert luminance[25:75, 25:75] == pytest.approx(50.0)
    luminance[25:75, 25:75] = 0
    assert luminance == pytest.approx(0.0)


def test_a_small_picture_is_enlarged() -> None:
    luminance = sensor_luminance(
        np.full((10, 30, 3), 255, np.uint8), size=(64, 48), white_cd_m2=9.0, transfer="srgb"
    )
    assert luminance.shape == (48, 64)
    assert luminance == pytest.approx(9.0)


def test_luminance_is_averaged_not_grey_levels() -> None:
    stripes = np.zeros((100, 100), np.uint8)
    stripes[::2] = 255
    luminance = sensor_luminance(stripes, size=(50, 50), white_cd_m2=100.0, transfer="srgb")
    assert luminance == pytest.approx(50.0)


def test_floating_point_pictures_are_luminance() -> None:
    luminance = sensor_luminance(
        np.full((5, 5), 3.25), size=(5, 5), white_cd_m2=1.0, transfer="srgb"
    )
    assert np.all(luminance == 3.25)


def test_a_negative_white_is_refused() -> None:
    with pytest.raises(FrameError, match="white_cd_m2 is -1"):
        sensor_luminance(np.zeros((5, 5), np.uint8), size=(5, 5), white_cd_m2=-1.0, transfer="srgb")
