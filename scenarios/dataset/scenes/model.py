"""Any MuJoCo model that moves along a trajectory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.events import Events
from scenarios.dataset.labels.kinds import Label
from scenarios.dataset.scenes.labelled import FrameTruth, LuminanceAt, SceneObject
from scenarios.dataset.scenes.model_take import ModelTake
from scenarios.dataset.scenes.trajectory import digest_of, trajectory_of
from scenarios.errors import ScenarioError
from sim import EventTruth, PhotometricCamera, Pose, open_model
from sim.event_truth import Clock, traced_events
from sim.motion.sample_times import sample_times_us
from sim.moving_model import MovingModel, compiled_bytes
from sim.photometric_camera import check_light
from sim.raster import flow
from sim.render.illumination import named_illumination
from sim.scene import srgb
from sim.truth.object_labels import AREA, box_of, label_objects

F32 = npt.NDArray[np.float32]
_OF_RIGID_BODIES = (Label.FLOW, Label.EVENT_SOURCE, Label.EVENT_FLOW)
_WHITE_PERCENTILE = 99.0
"""Percentile of the first image's luminance that previews show as white (chosen by eye)."""


class ModelScene:
    """A model that moves along a trajectory; see `LabelledScene`."""

    def __init__(self, take: ModelTake, width: int, height: int) -> None:
        """Open the model; nothing is rendered yet.

        Args:
            take: model, camera and trajectory.
            width: width of the image [px].
            height: height of the image [px].

        Raises:
            ScenarioError: the trajectory cannot be found, or fails.
            SceneConfigError: the model cannot be opened, or has no such camera or light.
        """
        self._take, self._model = take, open_model(take.path)
        place, duration_s = trajectory_of(take, self._model)
        self._moving = MovingModel(
            self._model, take.camera, place, width=width, height=height, objects=take.objects
        )
        self.lens, self.duration_us = self._moving.lens, round(duration_s * 1e6)
        self.objects: Sequence[SceneObject] = self._moving.objects
        self._fastest_px_s = 0.0

    def check(self, labels: Sequence[Label]) -> None:
        """Check what needs no renderer: light, labels, and the trajectory at three times.

        Raises:
            ScenarioError: the scene cannot give one of the labels, or the trajectory fails.
            SceneConfigError: there is no light.
        """
        if self._take.light is None:
            check_light(self._model)
        else:
            named_illumination(self._take.light)
        for t_us in (0, self.duration_us // 2, self.duration_us):
            self._moving.fastest_px_s(t_us * 1e-6)
        impossible = [label for label in labels if label in _OF_RIGID_BODIES]
        if impossible and self._moving.deforming:
            part = self._moving.deforming[0]
            raise ScenarioError(
                f"labels.wanted holds {impossible[0].value!r}, and the model {self._take.file} has "
                f"the {part.kind} {part.name!r}, which deforms. Such a model gives no "
                f"{', '.join(_OF_RIGID_BODIES)}. Write wanted = [...] without them, or remove what "
                "deforms."
            )

    def samples(self) -> Iterator[LuminanceAt]:
        """Render the sequence; between two samples nothing moves farther than `step_px`."""
        times = sample_times_us(
            0,
            self.duration_us,
            self._speed_px_s,
            step_px=self._take.step_px,
            max_step_us=round(self._take.max_step_ms * 1e3),
        )
        with self._camera(self._take.supersample) as camera:
            for t_us in times:
                yield LuminanceAt(t_us, camera.luminance(self._moving.data_at(t_us * 1e-6)))

    def frame(self, t_us: int) -> FrameTruth:
        """Return what the camera sees."""
        seen = self._moving.visible(t_us * 1e-6)
        labels, counts = label_objects(seen.body, self._moving.object_of_body, len(self.objects))
        boxes = [box_of(count) if count[AREA] else None for count in counts]
        return FrameTruth(t_us, flow.depth_m(seen), labels, boxes)

    def velocity_px_s(self, t_us: int) -> F32:
        """(height, width, 2) float32 image velocity of what each pixel shows."""
        return self._moving.flow_px_s(t_us * 1e-6)

    def displacement_px(self, from_us: int, to_us: int) -> F32:
        """(height, width, 2) float32 displacement of what each pixel shows at the first time."""
        return self._moving.displacement_px(from_us * 1e-6, to_us * 1e-6)

    def pose_at(self, t_us: int) -> Pose:
        """Return the pose of the camera."""
        return self._moving.pose_at(t_us * 1e-6)

    def event_truth(self, events: Events, causes: npt.NDArray[np.uint8]) -> EventTruth:
        """Return the source and the true flow of every event."""
        clock = Clock(lambda t_us: t_us * 1e-6, self._moving.fastest_px_s)
        return traced_events(events, causes, self._moving, clock)

    def images(self, times_us: Sequence[int]) -> Iterator[npt.NDArray[np.uint8]]:
        """Yield a grey preview for each time, all with the exposure of the first."""
        white: float | None = None
        with self._camera(self._take.supersample) as camera:
            for t_us in times_us:
                luminance = camera.luminance(self._moving.data_at(t_us * 1e-6))
                if white is None:
                    white = max(float(np.percentile(luminance, _WHITE_PERCENTILE)), 1e-9)
                grey = np.rint(255 * srgb.encoded(np.clip(luminance / white, 0.0, 1.0)))
                yield np.repeat(grey.astype(np.uint8)[..., None], 3, axis=-1)

    def facts(self) -> Mapping[str, Any]:
        """Return the highest image speed of all samples so far; a model has no one direction."""
        return {"direction": "", "image_speed_px_s": self._fastest_px_s, "illuminance_lux": None}

    def _speed_px_s(self, t_us: int) -> float:
        speed = self._moving.fastest_px_s(t_us * 1e-6)
        self._fastest_px_s = max(self._fastest_px_s, speed)
        return speed

    def _camera(self, supersample: int) -> PhotometricCamera:
        return PhotometricCamera(
            self._model,
            self._take.camera,
            width=self.lens.width,
            height=self.lens.height,
            supersample=supersample,
            still=True,  # MovingModel checks that something can move
            light=self._take.light,
        )


def take_digest(take: ModelTake) -> str:
    """Return a digest of the model, with its meshes and textures, and of its trajectory.

    Raises:
        SceneConfigError: the model cannot be opened.
        ScenarioError: the trajectory cannot be found.
    """
    return digest_of(take, compiled_bytes(open_model(take.path)))
