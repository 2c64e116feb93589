"""Motion detectors: they take events (and frames) and return the direction of motion.

`FlyDetector` is the fly of the paper. `FrameFly`, `ContrastMaximisation`, `EdgeInformedContrast`,
`PlaneFit`, `SpaceTimeFilters`, `SpikingDelays` and `TimeDifference` are the methods that it is
compared with.
All implement `Detector`: they take a stream in chunks of any size and return a list of
`MotionEstimate`.
"""

from detector.contrast_maximisation.detector import ContrastConfig, ContrastMaximisation
from detector.contrast_maximisation.edge_informed import EdgeInformedConfig, EdgeInformedContrast
from detector.errors import (
    DetectorConfigError,
    DetectorError,
    EventOrderError,
    FrameError,
    StateError,
)
from detector.estimate import Detector, FrameDetector, MotionEstimate
from detector.fly.config import FlyConfig
from detector.fly.detector import FlyDetector, FlyMaps
from detector.frame_fly.config import FrameFlyConfig
from detector.frame_fly.detector import FrameFly
from detector.plane_fit.detector import PlaneFit, PlaneFitConfig
from detector.space_time_filters.detector import SpaceTimeFilters, SpaceTimeFiltersConfig
from detector.spiking_delays.detector import SpikingDelays, SpikingDelaysConfig
from detector.time_difference.detector import TimeDifference, TimeDifferenceConfig
from flybench.direction import Direction

__all__ = [
    "ContrastConfig",
    "ContrastMaximisation",
    "Detector",
    "DetectorConfigError",
    "DetectorError",
    "Direction",
    "EdgeInformedConfig",
    "EdgeInformedContrast",
    "EventOrderError",
    "FlyConfig",
    "FlyDetector",
    "FlyMaps",
    "FrameDetector",
    "FrameError",
    "FrameFly",
    "FrameFlyConfig",
    "MotionEstimate",
    "PlaneFit",
    "PlaneFitConfig",
    "SpaceTimeFilters",
    "SpaceTimeFiltersConfig",
    "SpikingDelays",
    "SpikingDelaysConfig",
    "StateError",
    "TimeDifference",
    "TimeDifferenceConfig",
]
