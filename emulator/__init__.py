"""A DAVIS346 in software: luminance of a scene in, events with causes and APS frames out.

`Davis346` is the whole sensor. The order of the light through the files: `optics`,
`photoreceptor`, `change_detector`, `noise` (put together for one pixel by `pixel`, for many by
`batch` and `crossings`, for all by `scan` and `pixel_step`), `arbiter`, and `aps`.
"""

from emulator.aps import ApsFrame
from emulator.aps_config import ApsConfig
from emulator.arbiter import Readout
from emulator.biases import Bias, Biases, with_biases
from emulator.config import SensorConfig
from emulator.davis import Davis346, SensorOutput
from emulator.errors import EmulatorError, EventError, FitError, FrameError, SensorConfigError
from emulator.events import EVENT_DTYPE, Cause, Events, check_events, empty_events
from emulator.images import luminance_of
from emulator.presets import preset

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
    "Events",
    "FitError",
    "FrameError",
    "Readout",
    "SensorConfig",
    "SensorConfigError",
    "SensorOutput",
    "check_events",
    "empty_events",
    "luminance_of",
    "preset",
    "with_biases",
]
