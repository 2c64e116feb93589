"""The camera of a sequence: calibration, rectification map and pose, in DSEC's layout."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.dataset.layout import CALIBRATION, POSES, RECTIFY
from scenarios.dataset.scenes.labelled import LabelledScene
from scenarios.output.tables import write_table
from sim import Intrinsics

POSE_STEP_US = 1_000
"""Time between poses [µs] (assumed; shake has almost no power above 500 Hz)."""
POSE_COLUMNS = ("t_us", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")

_YAML = """\
# The lens has no distortion. Pixel centres have whole coordinates, as in OpenCV and DSEC.
intrinsics:
  cam0:
    camera_model: pinhole
    camera_matrix: {matrix}
    distortion_model: radtan
    distortion_coeffs: [0.0, 0.0, 0.0, 0.0]
    resolution: {size}
  camRect0:
    camera_model: pinhole
    camera_matrix: {matrix}
    resolution: {size}
extrinsics:
  R_rect0:
    - [1.0, 0.0, 0.0]
    - [0.0, 1.0, 0.0]
    - [0.0, 0.0, 1.0]
"""


def camera_matrix(lens: Intrinsics) -> list[float]:
    """Return fx, fy, cx, cy for pixel centres with whole coordinates [px].

    The renderer counts from the outer corner of the first pixel, half a pixel earlier.
    """
    centre_x, centre_y = lens.centre_px
    return [lens.focal_px, lens.focal_px * lens.aspect, centre_x - 0.5, centre_y - 0.5]


def write_rectify_map(work: Path, lens: Intrinsics) -> None:
    """Write the map of DSEC's loaders, which here returns every pixel unchanged."""
    rows, columns = np.mgrid[0 : lens.height, 0 : lens.width]
    with h5py.File(work / RECTIFY, "w") as file:
        file.create_dataset(
            "rectify_map",
            data=np.stack([columns, rows], axis=-1).astype(np.float32),
            compression="gzip",
            compression_opts=1,
            shuffle=True,
        )


def write_camera(work: Path, scene: LabelledScene) -> None:
    """Write the calibration, and the pose of the camera every millisecond.

    A pose is the position of the optical centre and the rotation from the camera's frame (right,
    down, forward) to the world's, as a unit quaternion. The world of a street is along the road,
    across it, up.
    """
    lens = scene.lens
    (work / CALIBRATION).parent.mkdir(parents=True, exist_ok=True)
    text = _YAML.format(matrix=camera_matrix(lens), size=[lens.width, lens.height])
    (work / CALIBRATION).write_text(text, encoding="utf-8")
    times_us = range(0, scene.duration_us + 1, POSE_STEP_US)
    poses = [scene.pose_at(t_us) for t_us in times_us]
    to_world = np.array([pose.world_to_camera[:, :3].T for pose in poses])
    quaternions = Rotation.from_matrix(to_world).as_quat(canonical=True)
    rows = (
        (t_us, *map(float, pose.position_m), *quaternion.tolist())
        for t_us, pose, quaternion in zip(times_us, poses, quaternions, strict=True)
    )
    write_table(work / POSES, POSE_COLUMNS, rows)
