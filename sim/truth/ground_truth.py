"""What is really so at a sample: the ground truth that a detector is judged on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from sim.geometry.rectangles import Rectangle

F64 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class ObjectTruth:
    """One moving object at one sample.

    Its reference is a point that moves with its root body: for the target the middle of its near
    flank, to which the configuration's distance is measured; for all others the middle of the box
    around them.

    Attributes:
        name: as the scene has it: "target", "far_vehicle", "pedestrian", "tree_0" and so on.
        kind: "sedan", "van", "motorcycle", "pedestrian" or "tree".
        reference_px: (2,) where the reference is in the image, also outside of it; not a number
            where it is behind the camera.
        image_velocity_px_s: (2,) its velocity there, x right and y down, as the camera sees it: if
            the camera shakes, its shake is included.
        angular_velocity_rad_s: how fast the reference's bearing turns about the vertical through
            the camera, whichever way; the camera's shake is no part of it.
        distance_m: from the camera to the reference.
        visibility: share of the pixels the object would take up alone, without the image's border
            and without anything before it, that the image shows; 0 to 1, to about 1 %.
        bounding_box_px: x0, y0, x1, y1 of the mask, half-open; None where it is empty.
        centroid_px: (2,) centre of gravity of the mask; None where it is empty.
        labels: (height, width) int8, which of the scene's objects each pixel's middle shows, by
            number; -1 for none. All objects of a sample share it.
        number: the object's own.
    """

    name: str
    kind: str
    reference_px: F64
    image_velocity_px_s: F64
    angular_velocity_rad_s: float
    distance_m: float
    visibility: float
    bounding_box_px: Rectangle | None
    centroid_px: F64 | None
    labels: I8
    number: int

    @property
    def mask(self) -> npt.NDArray[np.bool_]:
        """(height, width) bool, the pixels whose middle shows the object."""
        return np.asarray(self.labels == self.number)

    @property
    def in_view(self) -> bool:
        """Whether any pixel shows it."""
        return self.bounding_box_px is not None


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """All that moves at one sample; what is said of no object is said of the target.

    Attributes:
        t_us: time [µs].
        direction: of the target in the image.
        position_m: way of the target's middle from the point of closest approach [m].
        objects: of everything that moves, the target first.
    """

    t_us: int
    direction: Direction
    position_m: float
    objects: tuple[ObjectTruth, ...]

    @property
    def target(self) -> ObjectTruth:
        """The vehicle whose motion is to be detected."""
        return self.objects[0]

    @property
    def angular_velocity_rad_s(self) -> float:
        """Rate of the bearing of the target's flank, seen from the camera: v·d / (d² + s²)."""
        return self.target.angular_velocity_rad_s

    @property
    def image_velocity_px_s(self) -> F64:
        """(2,) velocity of the target's flank in the image; x right, y down."""
        return self.target.image_velocity_px_s

    @property
    def reference_px(self) -> F64:
        """(2,) where the middle of the target's flank is in the image, also outside of it."""
        return self.target.reference_px

    @property
    def visibility(self) -> float:
        """Share of the target's silhouette that the image shows, 0 to 1."""
        return self.target.visibility

    @property
    def mask(self) -> npt.NDArray[np.bool_]:
        """(height, width) bool, the pixels whose middle shows the target."""
        return self.target.mask

    @property
    def bounding_box_px(self) -> Rectangle | None:
        """Box x0, y0, x1, y1 of the target's mask, half-open; None where it is empty."""
        return self.target.bounding_box_px

    @property
    def centroid_px(self) -> F64 | None:
        """(2,) centre of gravity of the target's mask; None where it is empty."""
        return self.target.centroid_px

    @property
    def in_view(self) -> bool:
        """Whether any pixel shows the target."""
        return self.target.in_view
