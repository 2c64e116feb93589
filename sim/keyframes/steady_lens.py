"""Wider and finer lens of a steady camera, from whose image a shaking camera's is computed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sim.geometry.pinhole import Intrinsics
from sim.scene.scene import Scene

SHAKE_MARGIN_PX = 3
"""Margin beyond the largest displacement by shake, for the pixel's aperture (assumed)."""
SHAKE_SCALE = 3
"""Pixels of the steady camera per pixel of the shaking camera, along each axis: as many as the
default supersampling gives a steady camera."""


def steady_lens(scene: Scene, lens: Intrinsics, times_s: Sequence[float]) -> Intrinsics:
    """Return a lens for a steady camera that sees everything the shaking camera sees, but finer.

    Args:
        scene: scene with or without camera shake.
        lens: intrinsics of the shaking camera.
        times_s: sample times [s].

    Returns:
        The wider and finer lens; `lens` itself if the scene has no shake.
    """
    if scene.shake is None:
        return lens
    angle = max(float(np.linalg.norm(scene.shake.rotation_rad(t))) for t in times_s)
    corner = math.hypot(lens.width, lens.height) / 2 / lens.focal_px
    swing = math.tan(math.atan(corner) + angle) - corner
    margin_px = math.ceil(lens.focal_px * swing) + SHAKE_MARGIN_PX
    return lens.with_margin(margin_px).scaled(SHAKE_SCALE)
