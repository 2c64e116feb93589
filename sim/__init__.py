"""The photometric simulation: luminance of a scene in cd/m², with exact ground truth.

`Crossing` simulates a vehicle that crosses a street. `PhotometricCamera` works on any MuJoCo model.
"""

from flybench.direction import Direction
from sim.cache.luminance_cache import LuminanceCache
from sim.config import CrossingConfig, Lighting, Quality, omega_from_speed
from sim.crossing import Crossing, Sample
from sim.distractors import Distractors, Pavement, RelativeDirection, VehicleKind
from sim.errors import RendererError, SceneConfigError, SimError
from sim.event_truth import EventTruth, event_truth
from sim.geometry.pinhole import Intrinsics, Pose, project
from sim.motion.trajectory import Profile, Trajectory
from sim.photometric_camera import PhotometricCamera, open_model
from sim.preview import Preview, preview_jpegs
from sim.render.illumination import Illumination
from sim.scene.assets import ASSETS
from sim.truth.dense_truth import DenseTruth
from sim.truth.ground_truth import GroundTruth, ObjectTruth
from sim.truth.probe import TruthProbe

__all__ = [
    "ASSETS",
    "Crossing",
    "CrossingConfig",
    "DenseTruth",
    "Direction",
    "Distractors",
    "EventTruth",
    "GroundTruth",
    "Illumination",
    "Intrinsics",
    "Lighting",
    "LuminanceCache",
    "ObjectTruth",
    "Pavement",
    "PhotometricCamera",
    "Pose",
    "Preview",
    "Profile",
    "Quality",
    "RelativeDirection",
    "RendererError",
    "Sample",
    "SceneConfigError",
    "SimError",
    "Trajectory",
    "TruthProbe",
    "VehicleKind",
    "event_truth",
    "omega_from_speed",
    "open_model",
    "preview_jpegs",
    "project",
]
