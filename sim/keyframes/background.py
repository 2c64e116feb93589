"""The static background: its layers of light, which are rendered once, and its geometry."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

from sim.compositing.background import Background
from sim.geometry.pinhole import NEAR_M, Intrinsics, Pose
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.keyframes.background_layers import BackgroundLight
from sim.raster.aperture import to_pixels
from sim.raster.scan_conversion import empty_buffer, project_triangles, rasterise
from sim.raster.triangles import TriangleSoup, unit_normals

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
Numbers = npt.NDArray[np.int64]

FAR_NEARNESS = 1e-6
"""Nearness that stands for an infinite distance, such as the sky's [1/m] (assumed)."""


def background_of(
    light: BackgroundLight,
    lens: Intrinsics,
    data: mujoco.MjData,
    pose: Pose,
    soup: TriangleSoup,
    supersample: int,
    blur_px: float,
) -> Background:
    """Complete a rendered background by its pixels and its geometry.

    Args:
        light: what was rendered.
        lens: intrinsics of the camera.
        data: poses of the static objects.
        pose: pose of the camera.
        soup: triangles of the static objects.
        supersample: sub-pixels per pixel and axis.
        blur_px: standard deviation of the lens's point spread [px].
    """
    subpixels = np.ascontiguousarray(np.moveaxis(light.subpixels, -1, 0))
    subpixel_nearness, nearness, normals = _geometry(lens, data, pose, soup, supersample)
    return Background(
        pixels=np.stack([to_pixels(layer, supersample, blur_px) for layer in subpixels]),
        subpixels=subpixels,
        subpixel_albedo=light.subpixel_albedo,
        subpixel_nearness=subpixel_nearness,
        nearness=nearness,
        normals=normals,
    )


def _geometry(
    lens: Intrinsics, data: mujoco.MjData, pose: Pose, soup: TriangleSoup, supersample: int
) -> tuple[F32, F32, F32]:
    """Return the sub-pixels' nearness, and the pixel centres' nearness and normals."""
    subpixel_nearness = background_nearness(lens, data, pose, soup, supersample)
    in_camera = soup.transformed(compose_transforms(body_poses(data), pose.world_to_camera))
    nearness, label = rasterise_image(in_camera, lens, 1)
    normals = np.concatenate([unit_normals(in_camera), np.zeros((1, 3))])[label]
    nearness = np.maximum(nearness, np.float32(FAR_NEARNESS))
    return (
        subpixel_nearness,
        nearness,
        np.ascontiguousarray(np.moveaxis(normals, -1, 0), np.float32),
    )


def background_nearness(
    lens: Intrinsics, data: mujoco.MjData, pose: Pose, soup: TriangleSoup, supersample: int
) -> F32:
    """Return the nearness of the background at all sub-pixels of the image.

    Args:
        lens: intrinsics of the camera.
        data: poses of the static objects.
        pose: pose of the camera.
        soup: triangles of the static objects.
        supersample: sub-pixels per pixel and axis.

    Returns:
        (rows, columns) float32 [1/m].
    """
    in_camera = soup.transformed(compose_transforms(body_poses(data), pose.world_to_camera))
    nearness, _ = rasterise_image(in_camera, lens, supersample)
    return np.maximum(nearness, np.float32(FAR_NEARNESS))


def rasterise_image(triangles: F64, lens: Intrinsics, supersample: int) -> tuple[F32, I32]:
    """Rasterise triangles at all sub-pixels of the image.

    Args:
        triangles: (n, 3, 3) triangles in the camera's frame [m].
        lens: intrinsics of the camera.
        supersample: sub-pixels per pixel and axis.

    Returns:
        Nearness [1/m] and index of the triangle, (rows, columns) each.
    """
    nearness, label = empty_buffer(lens.height * supersample, lens.width * supersample)
    centre = lens.width * supersample / 2, lens.height * supersample / 2
    projected, source = project_triangles(triangles, lens.focal_px * supersample, *centre, NEAR_M)
    rasterise(projected, source, 0, 0, nearness, label, True)
    return nearness, label
