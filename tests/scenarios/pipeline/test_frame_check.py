import pytest

from emulator.presets import WITHOUT_FRAMES, PresetName
from scenarios.commands.run import Run
from scenarios.errors import ScenarioError
from scenarios.options.sensor import SensorOptions
from scenarios.pipeline.frame_check import check_frames
from scenarios.sweep.parameters import make_config


@pytest.mark.parametrize("sensor", sorted(WITHOUT_FRAMES))
def test_a_detector_of_frames_is_refused_on_a_chip_without_them(sensor: PresetName) -> None:
    with pytest.raises(ScenarioError, match=f"frame-fly, which needs APS frames.*{sensor}"):
        check_frames(sensor, "frame-fly")
    check_frames(sensor, "plane-fit")


def test_a_detector_of_frames_is_accepted_on_a_chip_with_them() -> None:
    check_frames("davis240", "frame-fly")


def test_run_refuses_it_before_it_renders() -> None:
    with pytest.raises(ScenarioError, match="needs APS frames"):
        Run(sensor=SensorOptions("imx636"), also=("frame-fly",)).execute()


def test_a_sweep_refuses_it_before_its_first_point() -> None:
    with pytest.raises(ScenarioError, match="needs APS frames"):
        make_config({"sensor.preset": "dvs128", "method": "frame-fly"})
