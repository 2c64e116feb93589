"""PNG files of labels, and the 16-bit codes of DSEC (flow) and KITTI (depth) in them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

F32 = npt.NDArray[np.float32]
U16 = npt.NDArray[np.uint16]
Bools = npt.NDArray[np.bool_]

FLOW_SCALE, FLOW_ZERO = 128, 1 << 15
"""Codes of flow are flow · 128 + 2¹⁵ (DSEC): 1/128 px apart, for −256 px to just below 256 px."""
DEPTH_SCALE = 256
"""Codes of depth are depth · 256 (KITTI): 1/256 m apart, up to 256 m; 0 means no depth."""
_CODES = 1 << 16


def write_png(path: Path, image: npt.NDArray[Any]) -> None:
    """Write an image of 8 or 16 bits with one channel, or with three in the order R, G, B."""
    ordered = image[..., ::-1] if image.ndim == 3 else image  # OpenCV takes B, G, R
    path.write_bytes(cv2.imencode(".png", np.ascontiguousarray(ordered))[1].tobytes())


def read_png(path: Path) -> npt.NDArray[Any]:
    """Read an image that `write_png` wrote.

    Raises:
        OSError: the file cannot be read, or is not an image.
    """
    image = cv2.imdecode(np.frombuffer(path.read_bytes(), np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise OSError(f"{path} is not an image")
    return np.ascontiguousarray(image[..., ::-1] if image.ndim == 3 else image)


def encode_flow(displacement_px: F32) -> U16:
    """Return displacement as the codes of DSEC.

    Args:
        displacement_px: (height, width, 2) x and y [px]; NaN where unknown.

    Returns:
        (height, width, 3) uint16: codes of x and y, and 1 where valid. Displacements that are
        unknown, or too large for the code, are 0, 0, 0.
    """
    codes = np.rint(displacement_px.astype(np.float64) * FLOW_SCALE) + FLOW_ZERO
    valid = ((codes >= 0) & (codes < _CODES)).all(axis=-1)  # False for NaN
    coded = np.zeros((*valid.shape, 3), np.uint16)
    coded[valid, :2] = codes[valid]
    coded[valid, 2] = 1
    return coded


def decode_flow(coded: U16) -> tuple[F32, Bools]:
    """Return displacement and validity from the codes of DSEC.

    Args:
        coded: (height, width, 3) uint16; see `encode_flow`.

    Returns:
        (height, width, 2) float32 x and y [px], 0 where not valid; and (height, width) bool.
    """
    valid = coded[..., 2] > 0
    flow = (coded[..., :2].astype(np.float32) - FLOW_ZERO) / FLOW_SCALE
    flow[~valid] = 0
    return np.asarray(flow, np.float32), valid


def encode_depth(depth_m: F32) -> U16:
    """Return depth as the codes of KITTI.

    Args:
        depth_m: (height, width) [m]; infinite for the sky.

    Returns:
        (height, width) uint16; 0 for the sky, and for what is farther than the code reaches.
    """
    codes = np.rint(depth_m.astype(np.float64) * DEPTH_SCALE)
    return np.asarray(np.where(codes < _CODES, codes, 0), np.uint16)


def decode_depth(coded: U16) -> F32:
    """Return depth from the codes of KITTI [m]; infinite where there is none."""
    depth = coded.astype(np.float32) / DEPTH_SCALE
    depth[coded == 0] = np.inf
    return np.asarray(depth)
