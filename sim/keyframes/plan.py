"""Plan of a sequence's keyframes: when each object needs one."""

from __future__ import annotations

from collections.abc import Callable, Sequence

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
        stride: only every `stride`-th sample is examined.

    Returns:
        Times of the keyframes [µs] by object name; and the areas that shadows and beams change at
        any of the times.
    """
    times = sorted({*times_us[::stride], times_us[-1]})
    corners_m = np.empty((len(scene.objects), len(times), 8, 3))
    affected: list[Rectangle] = []
    for k, t_us in enumerate(times):
        place(t_us)
        corners_m[:, k] = [obj.corners_m(data) for obj in scene.objects]
        affected = merge_overlapping(affected + finder.find(data).rectangles)
    plan = {}
    for obj, corners in zip(scene.objects, corners_m, strict=True):
        pixels, depth = project(corners.reshape(-1, 3), scene.pose, lens)
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

    Args:
        times_us: (n,) times to choose from [µs].
        corners_px: (n, 8, 2) image coordinates of the corners of the object's bounding box.
        in_view: (n,) True if the object is in view.
        spacing_px: maximum displacement of a corner from one keyframe to the next [px].
        longest_us: maximum time between keyframes [µs]; None for no limit.

    Returns:
        Times of the keyframes [µs]; empty if the object is never in view.
    """
    seen = np.flatnonzero(in_view)
    if not seen.size:
        return []
    chosen = [int(seen[0])]
    for k in range(int(seen[0]) + 1, int(seen[-1]) + 1):
        late = longest_us is not None and times_us[k] - times_us[chosen[-1]] >= longest_us
        if late or np.abs(corners_px[k] - corners_px[chosen[-1]]).max() >= spacing_px:
            chosen.append(k)
    if chosen[-1] != seen[-1]:
        chosen.append(int(seen[-1]))
    return [times_us[k] for k in chosen]
