"""Images of a rotated camera, compared with where `project` puts things."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Intrinsics, Pose, project
from sim.keyframes.rotation_warp import TABLE_STEPS, aperture_table, rotated_image
from sim.raster.aperture import LENS_BLUR_PX, to_pixels

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

LENS = Intrinsics(width=80, height=60, focal_px=90.0)
WIDE = LENS.with_margin(12)
STEADY = Pose(np.array([0.0, -5.0, 1.0]))


def rotated(rotation_rad: F64) -> Pose:
    """Return `STEADY` after successive rotations about its right, up and forward axes."""
    frame = np.stack([STEADY.right, STEADY.up, STEADY.forward])
    for axis, angle in enumerate(rotation_rad):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        a, b = frame[first].copy(), frame[second].copy()
        frame[first] = np.cos(angle) * a + np.sin(angle) * b
        frame[second] = np.cos(angle) * b - np.sin(angle) * a
    return Pose(STEADY.position_m, right=frame[0], up=frame[1])


def blob(centre_px: F64, lens: Intrinsics) -> F32:
    """Return a Gaussian spot on a ground of 1, with a standard deviation of 2 pixels of `LENS`."""
    width = 8 * (lens.focal_px / LENS.focal_px) ** 2
    x, y = np.meshgrid(np.arange(lens.width) + 0.5, np.arange(lens.height) + 0.5)
    off = (x - centre_px[0]) ** 2 + (y - centre_px[1]) ** 2
    return np.asarray(1 + 9 * np.exp(-off / width), np.float32)


def centroid_px(image: F32) -> F64:
    weights = np.maximum(image - 1.05, 0)
    x, y = np.meshgrid(np.arange(image.shape[1]) + 0.5, np.arange(image.shape[0]) + 0.5)
    moments = np.array([(x * weights).sum(), (y * weights).sum()])
    return np.asarray(moments / weights.sum())


def test_without_rotation_the_image_is_unchanged() -> None:
    image = np.random.default_rng(0).uniform(1, 2, (60, 80)).astype(np.float32)
    seen = rotated_image(image, STEADY, LENS, STEADY, LENS, 0.0)
    np.testing.assert_allclose(seen, image, rtol=1e-5)
    wide = np.random.default_rng(1).uniform(1, 2, (84, 104)).astype(np.float32)
    seen = rotated_image(wide, STEADY, WIDE, STEADY, LENS, 0.0)
    np.testing.assert_allclose(seen, wide[12:-12, 12:-12], rtol=1e-5)


@pytest.mark.parametrize("scale", [3, 4, 5])
def test_without_rotation_pixels_are_weighted_with_the_aperture(scale: int) -> None:
    wide = LENS.scaled(scale)
    image = np.random.default_rng(2).uniform(1, 3, (60 * scale, 80 * scale)).astype(np.float32)
    seen = rotated_image(image, STEADY, wide, STEADY, LENS)
    np.testing.assert_allclose(seen, to_pixels(image, scale), rtol=0.02)


@pytest.mark.parametrize("rotation_deg", [(2, 0, 0), (0, 2, 0), (0, 0, 5), (-1, 2, 3)])
@pytest.mark.parametrize("scale", [1, 2, 3])
def test_a_spot_appears_where_the_rotated_camera_projects_it(
    rotation_deg: tuple[float, float, float], scale: int
) -> None:
    pose = rotated(np.radians(rotation_deg))
    wide = WIDE.scaled(scale)
    for x, z in ((0.4, 1.2), (1.0, 1.5), (-1.2, 0.4)):
        point = np.array([[x, 0.0, z]])
        before, wanted = (project(point, *to)[0][0] for to in ((STEADY, wide), (pose, LENS)))
        seen = rotated_image(blob(before, wide), STEADY, wide, pose, LENS)
        assert seen.shape == (60, 80)
        np.testing.assert_allclose(centroid_px(seen), wanted, atol=0.03)
        assert np.linalg.norm(wanted - (before / scale - 12)) > 0.5


@pytest.mark.parametrize("shift_px", [0.1, 0.37, 0.5, 0.81])
def test_the_skirt_of_a_bright_edge_is_that_of_the_aperture(shift_px: float) -> None:
    scale, bright = 12, 1000.0
    wide = LENS.scaled(scale)
    image = np.ones((60 * scale, 80 * scale), np.float32)
    image[:, 40 * scale :] = bright
    pose = rotated(np.array([0.0, np.arctan(shift_px / LENS.focal_px), 0.0]))
    row = rotated_image(image, STEADY, wide, pose, LENS)[30]
    edge_px = 40 + shift_px * np.sign(500 - row[39:41].mean())
    table = aperture_table(LENS_BLUR_PX)
    aperture = np.concatenate([table[:0:-1], table])
    reach = (len(aperture) // 2) / TABLE_STEPS
    distance = np.linspace(-reach, reach, len(aperture))
    covered = np.cumsum(aperture) / aperture.sum()
    wanted = 1 + (bright - 1) * np.interp(np.arange(80) + 0.5 - edge_px, distance, covered)
    np.testing.assert_allclose(np.log(row[36:44]), np.log(wanted[36:44]), atol=0.25)


def test_luminance_is_never_negative() -> None:
    image = np.zeros((60, 80), np.float32)
    image[::7, ::5] = 1e5
    seen = rotated_image(image, STEADY, LENS, rotated(np.radians([0.1, 0.2, 1.0])), LENS)
    assert seen.min() == 0
