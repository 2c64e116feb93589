"""The lens of the steady camera sees everything that the shaking camera sees."""

import numpy as np
import pytest

from sim import CrossingConfig, Distractors, Intrinsics
from sim.keyframes.rotation_warp import SHAKE_SCALE, steady_lens
from sim.scene.scene import build_scene

LENS = Intrinsics(width=80, height=60, focal_px=70.0)
TIMES_S = [float(t) for t in np.linspace(-1, 1, 40)]


def test_without_shake_the_lens_is_unchanged() -> None:
    assert steady_lens(build_scene(CrossingConfig()), LENS, TIMES_S) is LENS


@pytest.mark.parametrize("rms_deg", [0.1, 1.0])
def test_the_border_of_every_shaken_image_is_inside_the_steady_image(rms_deg: float) -> None:
    scene = build_scene(CrossingConfig(distractors=Distractors(shake_rms_deg=rms_deg)))
    wide = steady_lens(scene, LENS, TIMES_S)
    assert wide.focal_px == SHAKE_SCALE * LENS.focal_px
    border = [(x, y) for x in (0, 40, 80) for y in (0, 30, 60) if (x, y) != (40, 30)]
    for t_s in TIMES_S:
        rotation = scene.pose.world_to_camera[:, :3] @ scene.pose_at(t_s).world_to_camera[:, :3].T
        for x, y in border:
            ray = rotation @ [(x - 40) / LENS.focal_px, (y - 30) / LENS.focal_px, 1]
            column, row = wide.focal_px * ray[:2] / ray[2] + [wide.width / 2, wide.height / 2]
            assert 0 <= column <= wide.width
            assert 0 <= row <= wide.height
