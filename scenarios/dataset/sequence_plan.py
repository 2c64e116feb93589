"""Everything that determines the files of one sequence."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from functools import cache

from emulator import SensorConfig
from flybench.sources import sources_digest
from scenarios.dataset.draws import CROSSING
from scenarios.dataset.labels.kinds import Label
from scenarios.dataset.scenes.labelled import LabelledScene
from scenarios.dataset.scenes.model import ModelScene, take_digest
from scenarios.dataset.scenes.model_take import MODEL, ModelTake
from scenarios.dataset.scenes.street import StreetScene
from scenarios.errors import ScenarioError
from scenarios.output.versions import versions
from scenarios.pipeline.run_config import flatten
from scenarios.sweep.parameters import PRESET
from sim import CrossingConfig, Intrinsics

SENSOR_SEED = "seed"
_SOURCES = (
    "flybench",
    "sim",
    "emulator",
    "formats/writers",
    "scenarios/dataset/labels",
    "scenarios/dataset/scenes",
    "scenarios/dataset/layout.py",
    "scenarios/dataset/sequence.py",
)
"""Sources that determine the files of a sequence."""


@cache
def code_digest() -> str:
    """Return a digest of this process's versions and of the sources that determine a sequence."""
    digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
    digest.update(sources_digest(*_SOURCES).encode())
    return digest.hexdigest()


@dataclass(frozen=True)
class SequencePlan:
    """Everything that determines the files of one sequence.

    Attributes:
        split: name of its split.
        number: its number in the split, from 0 on.
        name: path of its folder in the dataset, such as "train/0000".
        variant: name of its variant; empty if there are none.
        sensor_name: preset or file of the sensor.
        scene: street or model, and its motion.
        scene_digest: digest of a model and its trajectory; empty for a street.
        sensor: the event camera.
        seed: seed of the sensor.
        labels: labels to write.
        period_us: time between labels [µs].
        drawn: names of the parameters that are drawn.
    """

    split: str
    number: int
    name: str
    variant: str
    sensor_name: str
    scene: CrossingConfig | ModelTake
    sensor: SensorConfig
    seed: int
    labels: tuple[Label, ...]
    period_us: int
    drawn: tuple[str, ...] = ()
    scene_digest: str = ""

    @property
    def crossing(self) -> CrossingConfig:
        """The street.

        Raises:
            TypeError: the scene is a model.
        """
        if not isinstance(self.scene, CrossingConfig):
            raise TypeError("the scene is a model")
        return self.scene

    @property
    def lens(self) -> Intrinsics:
        """Lens of a street's camera. A camera of a model has its own field of view."""
        return Intrinsics(self.sensor.width, self.sensor.height, self.sensor.focal_length_px)

    def parameters(self) -> dict[str, object]:
        """Return every parameter by its dotted name, such as "crossing.omega_rad_s"."""
        tables = self.scene_parameters() | {"sensor": asdict(self.sensor)}
        return {PRESET: self.sensor_name} | dict(flatten(tables)) | {SENSOR_SEED: self.seed}

    def scene_parameters(self) -> dict[str, dict[str, object]]:
        """Return the parameters of the scene, in a table "crossing" or "model"."""
        if not isinstance(self.scene, CrossingConfig):
            return {MODEL: self.scene.parameters()}
        speed_km_h = self.scene.omega_rad_s * self.scene.distance * 3.6
        return {CROSSING: self.scene.resolved() | {"speed_km_h": speed_km_h}}

    def build_scene(self) -> LabelledScene:
        """Build the scene; nothing is rendered yet.

        Raises:
            ScenarioError: the files of a model have changed since the plan was made.
        """
        if isinstance(self.scene, CrossingConfig):
            return StreetScene(self.scene, self.lens)
        if take_digest(self.scene) != self.scene_digest:
            raise ScenarioError(
                f"{self.scene.path}, or the trajectory {self.scene.trajectory}, has changed since "
                "the start, or is another file on this worker. Allowed are the same files for all "
                "sequences. Start again."
            )
        return ModelScene(self.scene, self.sensor.width, self.sensor.height)

    def key(self) -> str:
        """Return a digest of everything that determines the files, except the machine."""
        inputs = {
            "parameters": self.parameters(),
            "scene": self.scene_digest,
            "labels": self.labels,
            "period_us": self.period_us,
            "code": code_digest(),
        }
        return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()
