"""An event sensor in software, from the luminance of a scene to events and frames.

`EventSensor` is the whole sensor, `SensorConfig` its parameters, and `preset` returns those of
known sensors. Light passes through the folders in this order: `pixel` (optics, photoreceptor,
change detector, noise) and `readout` for the events; `aps` for the frames. `characterisation`
measures the data sheet of a sensor.
"""

from emulator.aps.config import ApsConfig
from emulator.aps.frames import ApsFrame
from emulator.biases import Bias, Biases, with_biases
from emulator.config import SensorConfig
from emulator.errors import EmulatorError, FitError, FrameError, SensorConfigError
from emulator.grey_levels import luminance_of
from emulator.presets import preset
from emulator.readout.config import Lines, ReadoutConfig, ReadoutKind
from emulator.readout.stats import ReadoutStats
from emulator.sensor import Davis346, EventSensor, SensorOutput
from flybench.errors import EventError
from flybench.events import EVENT_DTYPE, Cause, Events, check_events, empty_events

__all__ = [
    "EVENT_DTYPE",
    "ApsConfig",
    "ApsFrame",
    "Bias",
    "Biases",
    "Cause",
    "Davis346",
    "EmulatorError",
    "EventError",
    "EventSensor",
    "Events",
    "FitError",
    "FrameError",
    "Lines",
    "ReadoutConfig",
    "ReadoutKind",
    "ReadoutStats",
    "SensorConfig",
    "SensorConfigError",
    "SensorOutput",
    "check_events",
    "empty_events",
    "luminance_of",
    "preset",
    "with_biases",
]
