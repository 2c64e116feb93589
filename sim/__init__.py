"""The photometric scene: a vehicle crosses a street, in cd/m², with its ground truth."""

from sim.camera import Intrinsics, Pose, project
from sim.config import CrossingConfig, Direction, Lighting, omega_from_speed
from sim.crossing import Crossing, Sample
from sim.distractors import Distractors, Pavement, VehicleKind, Way
from sim.errors import RendererError, SceneConfigError, SimError
from sim.preview import Preview
from sim.trajectory import Profile, Trajectory
from sim.truth import GroundTruth

__all__ = [
    "Crossing",
    "CrossingConfig",
    "Direction",
    "Distractors",
    "GroundTruth",
    "Intrinsics",
    "Lighting",
    "Pavement",
    "Pose",
    "Preview",
    "Profile",
    "RendererError",
    "Sample",
    "SceneConfigError",
    "SimError",
    "Trajectory",
    "VehicleKind",
    "Way",
    "omega_from_speed",
    "project",
]
