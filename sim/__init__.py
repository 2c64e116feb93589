"""The photometric scene: a vehicle crosses a street, in cd/m², with its ground truth."""

from sim.cache import LightCache
from sim.camera import Intrinsics, Pose, project
from sim.config import CrossingConfig, Direction, Lighting, omega_from_speed
from sim.crossing import Crossing, Sample
from sim.distractors import Distractors, Pavement, VehicleKind, Way
from sim.errors import RendererError, SceneConfigError, SimError
from sim.event_truth import EventTruth, event_truth
from sim.photometric_camera import PhotometricCamera, open_model
from sim.preview import Preview, preview_jpegs
from sim.scene_geometry import SceneGeometry
from sim.trajectory import Profile, Trajectory
from sim.truth import GroundTruth, ObjectTruth
from sim.witness import Witness

__all__ = [
    "Crossing",
    "CrossingConfig",
    "Direction",
    "Distractors",
    "EventTruth",
    "GroundTruth",
    "Intrinsics",
    "LightCache",
    "Lighting",
    "ObjectTruth",
    "Pavement",
    "PhotometricCamera",
    "Pose",
    "Preview",
    "Profile",
    "RendererError",
    "Sample",
    "SceneConfigError",
    "SceneGeometry",
    "SimError",
    "Trajectory",
    "VehicleKind",
    "Way",
    "Witness",
    "event_truth",
    "omega_from_speed",
    "open_model",
    "preview_jpegs",
    "project",
]
