"""The lens of a camera at rest that stands for one that shakes: wider, and finer."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sim.geometry.pinhole import Intrinsics
from sim.scene.scene import Scene

SHAKE_MARGIN_PX = 3
"""Beyond the farthest that a shake turns the image: what a pixel's aperture asks for (assumed)."""
SHAKE_SCALE = 3
"""Points that the image of a camera at rest has for a pixel of the shaken camera, along each axis:
as many as the default supersampling gives a camera at rest."""


def steady_lens(scene: Scene, lens: Intrinsics, times_s: Sequence[float]) -> Intrinsics:
    """A lens that sees, from a camera at rest, all that the scene's shaking camera does, finer.

    Args:
        scene: whose camera shakes, or rests.
        lens: the camera's.
        times_s: when it looks [s].
    """
    if scene.shake is None:
        return lens
    angle = max(float(np.linalg.norm(scene.shake.rotation_rad(t))) for t in times_s)
    corner = math.hypot(lens.width, lens.height) / 2 / lens.focal_px
    swing = math.tan(math.atan(corner) + angle) - corner
    margin_px = math.ceil(lens.focal_px * swing) + SHAKE_MARGIN_PX
    return lens.grown(margin_px).scaled(SHAKE_SCALE)
