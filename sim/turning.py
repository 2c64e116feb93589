"""The image of a camera that has turned, from that of one at rest in the same place."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from sim.camera import Intrinsics, Pose
from sim.moves import into_camera

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]


def turned_image(image: F32, rest: Pose, wide: Intrinsics, turned: Pose, lens: Intrinsics) -> F32:
    """What a turned camera sees; a rotation maps rays to rays, whatever their depth.

    Args:
        image: (wide.height, wide.width) float32, of the camera at rest.
        rest: its pose.
        wide: its lens.
        turned: the pose wanted, in the same place.
        lens: the lens wanted.

    Returns:
        (lens.height, lens.width) float32.
    """
    rotation = into_camera(rest)[:, :3] @ into_camera(turned)[:, :3].T
    back = _middles(wide) @ rotation @ np.linalg.inv(_middles(lens))
    size = lens.width, lens.height
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    warped = cv2.warpPerspective(image, back, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(warped, np.float32)


def _middles(lens: Intrinsics) -> F64:
    """(3, 3) from a camera's frame to pixel numbers, the middle of pixel 0 being 0."""
    return np.array(
        [
            [lens.focal_px, 0, lens.width / 2 - 0.5],
            [0, lens.focal_px, lens.height / 2 - 0.5],
            [0, 0, 1],
        ]
    )
