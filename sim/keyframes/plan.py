"""Plan of a sequence's keyframes: when each object needs one."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence

import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import Intrinsics, project
from sim.geometry.rectangles import Rectangle, merge_overlapping
from sim.scene.scene import Scene
from sim.shadows.shadows_and_beams import AffectedAreaFinder

F64 = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

PLAN_STEP_PX = 4.0
"""Maximum displacement between the times at which keyframes and affected areas are planned [px]
(assumed)."""
FAR_PX = 4 * PLAN_STEP_PX
"""Displacement between two of these times above which all samples between them are examined
[px] (assumed: half of the default distance between keyframes)."""
LIMBS_KEYFRAME_US = 100_000
"""Maximum time between keyframes of an object with swinging limbs or boughs, however little the
whole object moves [µs] (assumed)."""


def plan_keyframes(
    scene: Scene,
    lens: Intrinsics,
    finder: AffectedAreaFinder,
    times_us: Sequence[int],
    place: Callable[[int], None],
    data: mujoco.MjData,
    *,
    spacing_px: float,
    stride: int,
) -> tuple[dict[str, list[int]], list[Rectangle]]:
    """Plan the keyframes of a sequence.

    Args:
        scene: the scene.
        lens: intrinsics of the camera.
        finder: finds the image areas that shadows and beams can change.
        times_us: times of the samples [µs].
        place: moves `data` to a time [µs].
        data: poses of the model; changed.
        spacing_px: maximum displacement of an object from one keyframe to the next [px].
        stride: only every `stride`-th sample is examined, unless something moves farther in
            between than is planned.

    Returns:
        Times of the keyframes [µs] by object name; and the areas that shadows and beams change at
        any of the times.
    """
    corners_m: dict[int, F64] = {}
    affected: list[Rectangle] = []

    def examine(numbers: Iterable[int]) -> None:
        """Find the corners of all objects, and the affected areas, at samples."""
        for number in numbers:
            place(times_us[number])
            corners_m[number] = np.array([obj.corners_m(data) for obj in scene.objects])
            affected[:] = merge_overlapping(affected + finder.find(data).rectangles)

    last = len(times_us) - 1
    some = sorted({*range(0, last, stride), last})
    examine(some)
    for early, late in itertools.pairwise(some):  # whose samples are farther apart than planned
        both = np.stack([corners_m[early], corners_m[late]]).reshape(-1, 3)
        pixels, _ = project(both, scene.pose, lens)
        early_px, late_px = np.nan_to_num(pixels, nan=np.inf).reshape(2, -1, 2)
        if not (np.abs(late_px - early_px) <= FAR_PX).all():
            examine(range(early + 1, late))
    numbers = sorted(corners_m)
    times = [times_us[number] for number in numbers]
    plan = {}
    for k, obj in enumerate(scene.objects):
        corners = np.concatenate([corners_m[number][k] for number in numbers])
        pixels, depth = project(corners, scene.pose, lens)
        pixels = np.nan_to_num(pixels.reshape(-1, 8, 2), nan=np.inf)
        plan[obj.name] = keyframe_times(
            times,
            pixels,
            _in_view(pixels, depth.reshape(-1, 8), lens),
            spacing_px,
            LIMBS_KEYFRAME_US if obj.has_limbs else None,
        )
    return plan, affected


def _in_view(pixels: F64, depth: F64, lens: Intrinsics) -> Bools:
    """Return True for each box, (n, 8, 2) corners, that may be in view within a planning step."""
    size = np.array([lens.width, lens.height])
    low, high = pixels.min(axis=1), pixels.max(axis=1)
    margin = 2 * PLAN_STEP_PX
    inside = ((low < size + margin) & (high > -margin)).all(axis=1)
    return np.asarray(inside | (depth <= 0).any(axis=1))


def keyframe_times(
    times_us: Sequence[int],
    corners_px: F64,
    in_view: Bools,
    spacing_px: float,
    longest_us: int | None = None,
) -> list[int]:
    """Choose the times of an object's keyframes, from when it is first in view to when it is last.

    Where it moves by more than `spacing_px` between two times, both have a keyframe.

    Args:
        times_us: (n,) times to choose from [µs].
        corners_px: (n, 8, 2) image coordinates of the corners of the object's bounding box.
        in_view: (n,) True if the object is in view.
        spacing_px: maximum displacement of a corner from one keyframe to the next [px].
        longest_us: maximum time between keyframes [µs]; None for no limit.

    Returns:
        Times of the keyframes [µs]; empty if the object is never in view.
    """

    def is_due(k: int, before: int) -> bool:
        """Return True if there must be a keyframe at k or before it, after that at `before`."""
        late = longest_us is not None and times_us[k] - times_us[before] >= longest_us
        return late or bool(np.abs(corners_px[k] - corners_px[before]).max() >= spacing_px)

    seen = np.flatnonzero(in_view)
    if not seen.size:
        return []
    chosen = [int(seen[0])]
    for k in range(int(seen[0]) + 1, int(seen[-1]) + 1):
        if is_due(k, chosen[-1]):
            if chosen[-1] < k - 1 and is_due(k, k - 1):
                chosen.append(k - 1)
            chosen.append(k)
    if chosen[-1] != seen[-1]:
        chosen.append(int(seen[-1]))
    return [times_us[k] for k in chosen]
