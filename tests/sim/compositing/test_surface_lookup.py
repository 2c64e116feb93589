"""Surfaces of movers between keyframes, known in closed form."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.keyframes.store import Keyframe, KeyframeStore, cut_patches
from sim.raster.aperture import LENS_BLUR_PX, to_pixels
from sim.scene.moving_objects import MovingObject
from tests.sim.flat_background import LENS, composited, effects, flat_background
from tests.sim.keyframed_mover import (
    BACKGROUND_M,
    MOVER_M,
    PROJECTION,
    at_once,
    even_surface,
    label_of_shape,
    nearness_of,
    subpixel_grid,
    surfaces_between,
    view_at,
)

F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]

SIZES = [2, 3, 4]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("late", [0.0, 0.3, 1.0])
def test_a_pattern_moves_with_its_body(size: int, late: float) -> None:
    """In one keyframe the body is 0.3 m to the left and nearer, in the other 0.5 m to the right."""
    views = view_at(-0.3, 0.0, MOVER_M - 0.5), view_at(0.5, 0.4)
    now = view_at(0.1, 0.2, MOVER_M + 0.3)
    images, labels = zip(*(ramp(view, size) for view in views), strict=True)
    wanted, label = ramp(now, size)
    surfaces = surfaces_between(list(images), list(labels), size, now, views, late)
    nearness = np.where(label == 1, 1 / now[2, 3], 1 / BACKGROUND_M).astype(np.float32)
    background = flat_background(BACKGROUND_M, np.array([10.0]), supersample=size)
    image = composited(background, effects(1.0), surfaces, label, nearness)
    pixels = wanted.reshape(LENS.height, size, LENS.width, size).mean(axis=(1, 3))
    whole = to_pixels((label == 1).astype(np.float32), size) > 1 - 1e-6
    assert whole.sum() > 200
    # With even supersampling, the sub-pixel after the pixel centre is taken, at the same offset in
    # both images. At a depth a fifth greater this is wrong by a fifth of a quarter of a pixel.
    pixel_m = 50 / LENS.focal_px * now[2, 3]
    tolerance = 0.0 if size % 2 else 0.25 * 0.25 * pixel_m
    np.testing.assert_allclose(image[whole], pixels[whole], rtol=1e-4, atol=tolerance)


def ramp(view: F64, size: int) -> tuple[F64, I32]:
    """Return luminance 100 + 20 x + 30 y and labels of a square of 1.6 m about a body's origin."""
    x, y = subpixel_grid(size)
    depth = view[2, 3]
    x_m = (x - LENS.width / 2) / LENS.focal_px * depth - view[0, 3]
    y_m = (y - LENS.height / 2) / LENS.focal_px * depth - view[1, 3]
    label = np.where((np.abs(x_m) < 0.8) & (np.abs(y_m) < 0.8), 1, -1).astype(np.int32)
    return 100 + 20 * x_m + 30 * y_m, label


def slanted_ramp(view: F64, size: int) -> tuple[F64, F64, I32]:
    """Return luminance, depth and labels of a square whose depth grows by 2 m per metre right."""
    x, y = subpixel_grid(size)
    right, down = (x - LENS.width / 2) / LENS.focal_px, (y - LENS.height / 2) / LENS.focal_px
    depth = (view[2, 3] - 2 * view[0, 3]) / (1 - 2 * right)
    x_m, y_m = right * depth - view[0, 3], down * depth - view[1, 3]
    label = np.where((np.abs(x_m) < 0.8) & (np.abs(y_m) < 0.8), 1, -1).astype(np.int32)
    return 100 + 80 * x_m + 30 * y_m, depth, label


def test_at_edges_too_a_pattern_moves_according_to_its_depth() -> None:
    size, then, now = 3, view_at(-0.2), view_at(0.2)
    pattern, _, label = slanted_ramp(then, size)
    views = then, then
    surfaces = surfaces_between([pattern, pattern], [label, label], size, now, views, 0.5)
    wanted, depth, label = slanted_ramp(now, size)
    nearness = np.where(label == 1, 1 / depth, 1 / BACKGROUND_M).astype(np.float32)
    background = flat_background(BACKGROUND_M, np.array([10.0]), supersample=size)
    image = composited(background, effects(1.0), surfaces, label, nearness)
    whole = to_pixels(np.where(label == 1, wanted, 10).astype(np.float32), size)
    np.testing.assert_allclose(image, whole, atol=1.5)


def test_points_that_no_keyframe_shows_get_the_mean_of_the_part() -> None:
    label = label_of_shape("disc", 3)
    surface = even_surface(label, 90.0, 3)
    elsewhere = np.roll(label, 60, axis=1)
    background = flat_background(BACKGROUND_M, np.array([10.0]))
    image = composited(background, effects(1.0), surface, elsewhere, nearness_of(elsewhere))
    np.testing.assert_allclose(image[17, 50:53], 90, rtol=1e-4)


def test_the_albedo_of_a_wheel_rotates_with_it_and_its_illumination_does_not() -> None:
    """The albedo grows along the wheel's x axis, the illumination along the vehicle's."""
    size = 3
    x, y = subpixel_grid(size)
    label = np.where((x - 30) ** 2 + (y - 20) ** 2 < 150, 1, -1).astype(np.int32)
    albedo = np.where(label == 1, 0.3 + 0.01 * (x - 30), 0).astype(np.float32)
    illumination = (100 + 2 * (x - 30)).astype(np.float32)
    none = np.empty(0, np.int64)
    vehicle = MovingObject("vehicle", "box", 2, np.array([2, 1]), none, np.zeros((2, 3)), none)
    whole = np.full(label.shape, 1, np.int32)

    def render(_: MovingObject, t_us: int) -> Keyframe:
        views = {1: view_at()}
        patches, lit = (
            cut_patches(image[None], mask, views, (0, 0), size, LENS_BLUR_PX, per_pixel=size)
            for image, mask in ((albedo, label), (illumination, whole))
        )
        return Keyframe(t_us, patches, lit)

    carriers = np.arange(3, dtype=np.int32)
    plan = {"vehicle": [0, 1000]}
    store = KeyframeStore(plan, (vehicle,), at_once(render), carriers=carriers, per_pixel=size)
    store.advance(500)
    # The disc's centre lies on the optical axis, so that it turns about itself.
    sine_and_cosine = np.column_stack([np.diag([-1.0, -1.0, 1.0]), [0, 0, MOVER_M]])
    background = flat_background(BACKGROUND_M, np.array([10.0]), supersample=size)
    views = np.stack([np.eye(3, 4), sine_and_cosine, view_at()])
    surfaces = store.surfaces(500, views, 1.0, PROJECTION)
    image = composited(background, effects(1.0), surfaces, label, nearness_of(label))
    for off in (-8, -3, 0, 5, 9):
        wanted = (0.3 - 0.01 * (off + 0.5)) * (100 + 2 * (off + 0.5))
        assert image[20, 30 + off] == pytest.approx(wanted, rel=0.01), off
