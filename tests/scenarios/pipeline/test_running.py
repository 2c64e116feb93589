"""The crossing of a run."""

from typing import Any

import pytest

from emulator import preset
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_crossing
from sim import CrossingConfig, Intrinsics


@pytest.mark.parametrize("name", ["davis346", "dvs128", "imx636"])
def test_a_run_has_the_field_of_view_of_its_sensor(name: Any) -> None:
    sensor = preset(name)
    lens = make_crossing(RunConfig(CrossingConfig(), sensor)).intrinsics
    assert (lens.width, lens.height) == (sensor.width, sensor.height)
    assert lens.focal_px == pytest.approx(6.0e3 / sensor.pixel_pitch_um)


def test_the_default_sensor_has_the_default_intrinsics() -> None:
    assert make_crossing(RunConfig(CrossingConfig())).intrinsics == Intrinsics()
