"""A vehicle that crosses a street."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.events import Events
from scenarios.dataset.scenes.labelled import FrameTruth, LuminanceAt, SceneObject
from sim import Crossing, CrossingConfig, EventTruth, Intrinsics, Pose, TruthProbe
from sim.event_truth import event_truth
from sim.preview import Preview
from sim.raster import flow

F32 = npt.NDArray[np.float32]


class StreetScene:
    """The scene of a crossing; see `LabelledScene`."""

    def __init__(self, config: CrossingConfig, lens: Intrinsics) -> None:
        """Build the scene; nothing is rendered yet."""
        self._crossing = Crossing(config, lens)
        self.lens, self.duration_us = lens, self._crossing.duration_us
        self.objects: Sequence[SceneObject] = self._crossing.scene.objects

    @cached_property
    def _probe(self) -> TruthProbe:
        return TruthProbe(self._crossing.scene, self.lens)

    def samples(self) -> Iterator[LuminanceAt]:
        """Render the sequence."""
        for sample in self._crossing.samples():
            yield LuminanceAt(sample.t_us, sample.luminance, sample.changed)

    def frame(self, t_us: int) -> FrameTruth:
        """Return what the camera sees."""
        t_s = self._crossing.seconds(t_us)
        seen = self._probe.geometry.visible(t_s)
        truth = self._probe.measure(t_us, t_s, seen.body)
        boxes = [item.bounding_box_px for item in truth.objects]
        return FrameTruth(t_us, flow.depth_m(seen), truth.target.labels, boxes, truth)

    def velocity_px_s(self, t_us: int) -> F32:
        """(height, width, 2) float32 image velocity of what each pixel shows."""
        return self._probe.geometry.flow_px_s(self._crossing.seconds(t_us))

    def displacement_px(self, from_us: int, to_us: int) -> F32:
        """(height, width, 2) float32 displacement of what each pixel shows at the first time."""
        seconds = self._crossing.seconds
        return self._probe.geometry.displacement_px(seconds(from_us), seconds(to_us))

    def pose_at(self, t_us: int) -> Pose:
        """Return the pose of the camera."""
        return self._crossing.scene.pose_at(self._crossing.seconds(t_us))

    def event_truth(self, events: Events, causes: npt.NDArray[np.uint8]) -> EventTruth:
        """Return the source and the true flow of every event."""
        return event_truth(events, causes, self._crossing)

    def images(self, times_us: Sequence[int]) -> Iterator[npt.NDArray[np.uint8]]:
        """Yield a preview in colour for each time."""
        with Preview(self._crossing) as preview:
            for t_us in times_us:
                yield preview.render(t_us, scale=1.0)

    def facts(self) -> Mapping[str, Any]:
        """Return direction, image speed and illuminance."""
        c = self._crossing.config
        return {
            "direction": c.direction.value,
            "image_speed_px_s": self.lens.focal_px * c.omega_rad_s,
            "illuminance_lux": c.illuminance,
        }
