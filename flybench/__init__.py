"""flybench: a test bench for event-camera motion detectors.

This package holds what all others share: the event array, directions, checks of values, compiled
kernels and the base of all errors. It is also the front door: `flybench.Crossing`,
`flybench.Davis346`, `flybench.FlyDetector` and every other public name of `sim`, `emulator`,
`detector`, `formats` and `scenarios` is imported when it is first used, so that `import flybench`
loads nothing heavy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flybench.lazy import lazy_names

if TYPE_CHECKING:
    from detector import (
        ContrastConfig as ContrastConfig,
    )
    from detector import (
        ContrastMaximisation as ContrastMaximisation,
    )
    from detector import (
        Detector as Detector,
    )
    from detector import (
        FlyConfig as FlyConfig,
    )
    from detector import (
        FlyDetector as FlyDetector,
    )
    from detector import (
        FrameDetector as FrameDetector,
    )
    from detector import (
        FrameFly as FrameFly,
    )
    from detector import (
        FrameFlyConfig as FrameFlyConfig,
    )
    from detector import (
        MotionEstimate as MotionEstimate,
    )
    from detector import (
        PlaneFit as PlaneFit,
    )
    from detector import (
        PlaneFitConfig as PlaneFitConfig,
    )
    from emulator import (
        ApsConfig as ApsConfig,
    )
    from emulator import (
        ApsFrame as ApsFrame,
    )
    from emulator import (
        Biases as Biases,
    )
    from emulator import (
        Davis346 as Davis346,
    )
    from emulator import (
        EventSensor as EventSensor,
    )
    from emulator import (
        ReadoutConfig as ReadoutConfig,
    )
    from emulator import (
        ReadoutKind as ReadoutKind,
    )
    from emulator import (
        SensorConfig as SensorConfig,
    )
    from emulator import (
        SensorOutput as SensorOutput,
    )
    from emulator import (
        luminance_of as luminance_of,
    )
    from emulator import (
        preset as preset,
    )
    from emulator import (
        with_biases as with_biases,
    )
    from flybench.direction import Direction as Direction
    from flybench.errors import EventError as EventError
    from flybench.errors import FlybenchError as FlybenchError
    from flybench.events import (
        EVENT_DTYPE as EVENT_DTYPE,
    )
    from flybench.events import (
        Cause as Cause,
    )
    from flybench.events import (
        Events as Events,
    )
    from flybench.events import (
        check_events as check_events,
    )
    from flybench.events import (
        empty_events as empty_events,
    )
    from flybench.version import __version__ as __version__
    from formats import (
        EventFile as EventFile,
    )
    from formats import (
        open_events as open_events,
    )
    from formats import (
        open_writer as open_writer,
    )
    from formats import (
        read_events as read_events,
    )
    from formats import (
        write_events as write_events,
    )
    from scenarios import EventCamera as EventCamera
    from sim import (
        Crossing as Crossing,
    )
    from sim import (
        CrossingConfig as CrossingConfig,
    )
    from sim import (
        Distractors as Distractors,
    )
    from sim import (
        GroundTruth as GroundTruth,
    )
    from sim import (
        Intrinsics as Intrinsics,
    )
    from sim import (
        Lighting as Lighting,
    )
    from sim import (
        LuminanceCache as LuminanceCache,
    )
    from sim import (
        PhotometricCamera as PhotometricCamera,
    )
    from sim import (
        Profile as Profile,
    )
    from sim import (
        RelativeDirection as RelativeDirection,
    )
    from sim import (
        Sample as Sample,
    )
    from sim import (
        VehicleKind as VehicleKind,
    )
    from sim import (
        event_truth as event_truth,
    )
    from sim import (
        omega_from_speed as omega_from_speed,
    )
    from sim import (
        open_model as open_model,
    )

_MODULES = {
    "flybench.version": ("__version__",),
    "flybench.direction": ("Direction",),
    "flybench.errors": (
        "EventError",
        "FlybenchError",
    ),
    "flybench.events": (
        "Cause",
        "EVENT_DTYPE",
        "Events",
        "check_events",
        "empty_events",
    ),
    "sim": (
        "Crossing",
        "CrossingConfig",
        "Distractors",
        "GroundTruth",
        "Intrinsics",
        "Lighting",
        "LuminanceCache",
        "PhotometricCamera",
        "Profile",
        "RelativeDirection",
        "Sample",
        "VehicleKind",
        "event_truth",
        "omega_from_speed",
        "open_model",
    ),
    "emulator": (
        "ApsConfig",
        "ApsFrame",
        "Biases",
        "Davis346",
        "EventSensor",
        "ReadoutConfig",
        "ReadoutKind",
        "SensorConfig",
        "SensorOutput",
        "luminance_of",
        "preset",
        "with_biases",
    ),
    "detector": (
        "ContrastConfig",
        "ContrastMaximisation",
        "Detector",
        "FlyConfig",
        "FlyDetector",
        "FrameDetector",
        "FrameFly",
        "FrameFlyConfig",
        "MotionEstimate",
        "PlaneFit",
        "PlaneFitConfig",
    ),
    "formats": (
        "EventFile",
        "open_events",
        "open_writer",
        "read_events",
        "write_events",
    ),
    "scenarios": ("EventCamera",),
}

__all__ = [
    "EVENT_DTYPE",
    "ApsConfig",
    "ApsFrame",
    "Biases",
    "Cause",
    "ContrastConfig",
    "ContrastMaximisation",
    "Crossing",
    "CrossingConfig",
    "Davis346",
    "Detector",
    "Direction",
    "Distractors",
    "EventCamera",
    "EventError",
    "EventFile",
    "EventSensor",
    "Events",
    "FlyConfig",
    "FlyDetector",
    "FlybenchError",
    "FrameDetector",
    "FrameFly",
    "FrameFlyConfig",
    "GroundTruth",
    "Intrinsics",
    "Lighting",
    "LuminanceCache",
    "MotionEstimate",
    "PhotometricCamera",
    "PlaneFit",
    "PlaneFitConfig",
    "Profile",
    "ReadoutConfig",
    "ReadoutKind",
    "RelativeDirection",
    "Sample",
    "SensorConfig",
    "SensorOutput",
    "VehicleKind",
    "__version__",
    "check_events",
    "empty_events",
    "event_truth",
    "luminance_of",
    "omega_from_speed",
    "open_events",
    "open_model",
    "open_writer",
    "preset",
    "read_events",
    "with_biases",
    "write_events",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy_names(__name__, _MODULES)
