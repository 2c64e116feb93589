"""Data classes of the ground truth against which detectors are scored."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from sim.geometry.rectangles import Rectangle

F64 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class ObjectTruth:
    """Ground truth of one moving object at one sample.

    The reference point moves with the object's root body. For the target it is the middle of the
    near flank, to which `CrossingConfig.distance_m` is measured. For every other object it is the
    middle of its bounding box in the scene.

    Attributes:
        name: name of the object in the scene: "target", "far_vehicle", "pedestrian", "tree_0" and
            so on.
        kind: "sedan", "van", "motorcycle", "pedestrian" or "tree".
        reference_px: (2,) image coordinates of the reference point, which may lie outside the
            image; NaN if it is behind the camera.
        image_velocity_px_s: (2,) image velocity of the reference point, x right and y down. It
            includes the camera's shake.
        angular_velocity_rad_s: rate, without sign, at which the bearing of the reference point
            turns about the vertical through the camera. It does not include the camera's shake.
        distance_m: distance from the camera to the reference point.
        bounding_box_px: x0, y0, x1, y1 of the mask, half-open; None if the mask is empty.
        centroid_px: (2,) centroid of the mask; None if the mask is empty.
        labels: (height, width) int8 number of the object that the middle of each pixel shows; -1
            for none. All objects of a sample share this array.
        number: number of this object in `labels`.
        measure_visibility: measures `visibility`, which costs more than all else.
    """

    name: str
    kind: str
    reference_px: F64
    image_velocity_px_s: F64
    angular_velocity_rad_s: float
    distance_m: float
    bounding_box_px: Rectangle | None
    centroid_px: F64 | None
    labels: I8
    number: int
    measure_visibility: Callable[[], float]

    @cached_property
    def visibility(self) -> float:
        """Share of the object's silhouette that the image shows, 0 to 1, to about 1 %.

        The silhouette is what an unlimited image would show if nothing stood in front.
        """
        return self.measure_visibility() if self.in_view else 0.0

    @property
    def mask(self) -> npt.NDArray[np.bool_]:
        """(height, width) bool: True where the middle of the pixel shows the object."""
        return np.asarray(self.labels == self.number)

    @property
    def in_view(self) -> bool:
        """True if at least one pixel shows the object."""
        return self.bounding_box_px is not None


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """Ground truth of one sample. The properties are shortcuts to those of the target.

    Attributes:
        t_us: time since the start of the sequence [µs].
        direction: direction of the target's image motion.
        position_m: distance of the target's middle past the point of closest approach [m].
        objects: ground truth of every moving object, the target first.
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
        """Rate at which the bearing of the target's flank turns: v·d / (d² + s²)."""
        return self.target.angular_velocity_rad_s

    @property
    def image_velocity_px_s(self) -> F64:
        """(2,) image velocity of the target's flank; x right, y down."""
        return self.target.image_velocity_px_s

    @property
    def reference_px(self) -> F64:
        """(2,) image coordinates of the middle of the target's flank, perhaps outside the image."""
        return self.target.reference_px

    @property
    def visibility(self) -> float:
        """Share of the target's silhouette that the image shows, 0 to 1."""
        return self.target.visibility

    @property
    def mask(self) -> npt.NDArray[np.bool_]:
        """(height, width) bool: True where the middle of the pixel shows the target."""
        return self.target.mask

    @property
    def bounding_box_px(self) -> Rectangle | None:
        """Bounding box x0, y0, x1, y1 of the target's mask, half-open; None if it is empty."""
        return self.target.bounding_box_px

    @property
    def centroid_px(self) -> F64 | None:
        """(2,) centroid of the target's mask; None if the mask is empty."""
        return self.target.centroid_px

    @property
    def in_view(self) -> bool:
        """True if at least one pixel shows the target."""
        return self.target.in_view
