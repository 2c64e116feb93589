"""A DAVIS346 in software: luminance of a scene in, events with causes and APS frames out.

`Davis346` is the whole sensor. The order of the light through the files: `optics`,
`photoreceptor`, `change_detector`, `noise` (put together by `pixel_step`), and `aps`.
"""

from emulator.aps import ApsFrame
from emulator.aps_config import ApsConfig
from emulator.config import SensorConfig
from emulator.davis import Davis346, SensorOutput
from emulator.errors import EmulatorError, EventError, FrameError, SensorConfigError
from emulator.events import EVENT_DTYPE, Cause, Events, check_events, empty_events

__all__ = [
    "EVENT_DTYPE",
    "ApsConfig",
    "ApsFrame",
    "Cause",
    "Davis346",
    "EmulatorError",
    "EventError",
    "Events",
    "FrameError",
    "SensorConfig",
    "SensorConfigError",
    "SensorOutput",
    "check_events",
    "empty_events",
]
