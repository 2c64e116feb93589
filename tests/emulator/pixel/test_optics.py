import math

import pytest

from emulator.pixel.optics import lux_per_cd_m2


def test_the_camera_equation() -> None:
    assert lux_per_cd_m2(f_number=2.0, transmission=1.0) == pytest.approx(math.pi / 16)


def test_one_stop_halves_the_illuminance() -> None:
    wide = lux_per_cd_m2(f_number=2.0, transmission=0.9)
    assert lux_per_cd_m2(f_number=2.0 * math.sqrt(2), transmission=0.9) == pytest.approx(wide / 2)
