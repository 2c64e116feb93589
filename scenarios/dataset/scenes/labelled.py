"""The interface of a scene that gives luminance and labels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from flybench.events import Events
from sim import EventTruth, GroundTruth, Intrinsics, Pose
from sim.geometry.rectangles import Rectangle
from sim.render.filament import Luminance

F32 = npt.NDArray[np.float32]


class SceneObject(Protocol):
    """A moving object. Its number is its place in the list of objects."""

    @property
    def name(self) -> str:
        """Name, unique in the scene."""
        ...

    @property
    def kind(self) -> str:
        """Kind, such as "sedan"; objects of a model are each of a kind of their own."""
        ...


@dataclass(frozen=True, eq=False)
class LuminanceAt:
    """Luminance at one time.

    Attributes:
        t_us: time since the start of the sequence [µs].
        luminance: (height, width) float32 mean luminance of each pixel [cd/m²].
        changed: rectangle outside of which nothing has changed since the last time [px]; None: all
            pixels may have.
    """

    t_us: int
    luminance: Luminance
    changed: Rectangle | None = None


@dataclass(frozen=True, eq=False)
class FrameTruth:
    """What the camera sees at the time of a label.

    Attributes:
        t_us: time since the start of the sequence [µs].
        depth_m: (height, width) float32 depth along the optical axis [m]; infinite for the sky.
        labels: (height, width) int8 number of the object that each pixel shows; -1 for none.
        boxes_px: bounding box x0, y0, x1, y1 of each object, half-open; None if it is not seen.
        motion: motion of the objects; None if the scene has no target.
    """

    t_us: int
    depth_m: F32
    labels: npt.NDArray[np.int8]
    boxes_px: Sequence[Rectangle | None]
    motion: GroundTruth | None = None


class LabelledScene(Protocol):
    """A scene with its camera. All times are since the start of the sequence [µs]."""

    @property
    def lens(self) -> Intrinsics:
        """Intrinsics of the camera."""
        ...

    @property
    def duration_us(self) -> int:
        """Length of the sequence."""
        ...

    @property
    def objects(self) -> Sequence[SceneObject]:
        """The moving objects."""
        ...

    def samples(self) -> Iterator[LuminanceAt]:
        """Render the sequence."""
        ...

    def frame(self, t_us: int) -> FrameTruth:
        """Return what the camera sees."""
        ...

    def velocity_px_s(self, t_us: int) -> F32:
        """(height, width, 2) float32 image velocity of what each pixel shows."""
        ...

    def displacement_px(self, from_us: int, to_us: int) -> F32:
        """(height, width, 2) float32 displacement of what each pixel shows at the first time."""
        ...

    def pose_at(self, t_us: int) -> Pose:
        """Return the pose of the camera."""
        ...

    def event_truth(self, events: Events, causes: npt.NDArray[np.uint8]) -> EventTruth:
        """Return the source and the true flow of every event."""
        ...

    def images(self, times_us: Sequence[int]) -> Iterator[npt.NDArray[np.uint8]]:
        """Yield a preview, (height, width, 3) sRGB, for each time."""
        ...

    def facts(self) -> Mapping[str, Any]:
        """Return what the summary of the sequence states about the scene."""
        ...
