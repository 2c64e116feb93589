"""A DAVIS346 in software: luminance of a scene in, events with causes and APS frames out.

`Davis346` is the whole sensor. The order of the light through the files: `optics`,
`photoreceptor`, `change_detector`, `noise` (put together for one pixel by `pixel`, for many by
`batch` and `crossings`, for all by `scan` and `pixel_step`), `arbiter`, and `aps`.
"""

from emulator.aps.config import ApsConfig
from emulator.aps.frames import ApsFrame
from emulator.biases import Bias, Biases, with_biases
from emulator.config import SensorConfig
from emulator.errors import EmulatorError, FitError, FrameError, SensorConfigError
from emulator.grey_levels import luminance_of
from emulator.presets import preset
from emulator.readout.arbiter import Readout
from emulator.sensor import Davis346, SensorOutput
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
