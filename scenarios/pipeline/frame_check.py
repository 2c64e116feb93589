"""Check that a detector which needs APS frames has a sensor that records them."""

from __future__ import annotations

from detector import FrameDetector
from emulator import preset
from emulator.presets import WITHOUT_FRAMES, PresetName
from scenarios.errors import ScenarioError
from scenarios.pipeline.user_detectors import find_method


def check_frames(sensor: PresetName, method: str) -> None:
    """Refuse a detector that needs APS frames if the chip of the sensor records none.

    Args:
        sensor: preset of the sensor.
        method: name of the detector; see `find_method`.

    Raises:
        ScenarioError: the detector needs frames, and the chip has none.
        MethodError: the detector of such a chip does not exist, or does not follow the protocol.
    """
    if sensor not in WITHOUT_FRAMES:
        return
    config = preset(sensor)
    detector = find_method(method).make(width=config.width, height=config.height)
    if isinstance(detector, FrameDetector):
        raise ScenarioError(
            f"The method is {method}, which needs APS frames, and the sensor is {sensor}, whose "
            "chip records none. Choose a sensor with frames, such as davis346, or another method, "
            "such as fly."
        )
