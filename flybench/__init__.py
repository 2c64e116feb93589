"""flybench: a test bench for event-camera motion detectors.

This package holds what all others share: the event array, directions, checks of values, compiled
kernels and the base of all errors. It is also the public interface: `flybench.Crossing`,
`flybench.Davis346`, `flybench.FlyDetector` and every other public name of `sim`, `emulator`,
`detector`, `formats` and `scenarios` is imported when it is first used, so that `import flybench`
loads nothing heavy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flybench.lazy import lazy_names

if TYPE_CHECKING:
    from detector import (
        ContrastConfig,
        ContrastMaximisation,
        Detector,
        FlyConfig,
        FlyDetector,
        FrameDetector,
        FrameFly,
        FrameFlyConfig,
        MotionEstimate,
        PlaneFit,
        PlaneFitConfig,
    )
    from emulator import (
        ApsConfig,
        ApsFrame,
        Biases,
        Davis346,
        EventSensor,
        ReadoutConfig,
        ReadoutKind,
        SensorConfig,
        SensorOutput,
        luminance_of,
        preset,
        with_biases,
    )
    from flybench.direction import Direction
    from flybench.errors import EventError, FlybenchError
    from flybench.events import (
        EVENT_DTYPE,
        Cause,
        Events,
        check_events,
        empty_events,
    )
    from flybench.version import __version__
    from formats import (
        EventFile,
        open_events,
        open_writer,
        read_events,
        write_events,
    )
    from scenarios import EventCamera
    from sim import (
        Crossing,
        CrossingConfig,
        Distractors,
        GroundTruth,
        Illumination,
        Intrinsics,
        Lighting,
        LuminanceCache,
        PhotometricCamera,
        Profile,
        RelativeDirection,
        Sample,
        VehicleKind,
        event_truth,
        omega_from_speed,
        open_model,
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
        "Illumination",
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
    "Illumination",
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
