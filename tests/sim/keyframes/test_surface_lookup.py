"""What movers' surfaces look like between keyframes, known in closed form."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.keyframes.store import Keyframe, KeyframeStore, cut_pieces
from sim.raster.aperture import LENS_BLUR_PX, to_pixels
from sim.scene.moving_objects import MovingObject
from tests.sim.flat import LENS, composed, flat_street, lights
from tests.sim.flat_movers import MOVER_M, STREET_M, at, even_mover, grid, near, shape, surfaces

F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]

SIZES = [2, 3, 4]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("late", [0.0, 0.3, 1.0])
def test_a_pattern_moves_with_its_body(size: int, late: float) -> None:
    """A flat ramp, seen 0.3 m to the left and 0.5 m nearer, and 0.5 m to the right and below."""
    then = at(-0.3, 0.0, MOVER_M - 0.5), at(0.5, 0.4)
    now = at(0.1, 0.2, MOVER_M + 0.3)
    fine, labels = zip(*(ramp(view, size) for view in then), strict=True)
    wanted, label = ramp(now, size)
    seen = surfaces(list(fine), list(labels), size, now, then, late)
    nearness = np.where(label == 1, 1 / now[2, 3], 1 / STREET_M).astype(np.float32)
    street = flat_street(STREET_M, np.array([10.0]), size=size)
    image = composed(street, lights(1.0), seen, label, nearness)
    pixels = wanted.reshape(LENS.height, size, LENS.width, size).mean(axis=(1, 3))
    whole = to_pixels((label == 1).astype(np.float32), size) > 1 - 1e-6
    assert whole.sum() > 200
    # Where no point is a pixel's middle, the one after it is taken as far from it there as here:
    # at a fifth greater distance wrong by a fifth of a quarter of a pixel.
    a_pixel = 50 / LENS.focal_px * now[2, 3]
    slack = 0.0 if size % 2 else 0.25 * 0.25 * a_pixel
    np.testing.assert_allclose(image[whole], pixels[whole], rtol=1e-4, atol=slack)


def ramp(view: F64, size: int) -> tuple[F64, I32]:
    """Luminance 100 + 20 x + 30 y of a square of 1.6 m about a body's origin, and labels."""
    x, y = grid(size)
    depth = view[2, 3]
    x_m = (x - LENS.width / 2) / LENS.focal_px * depth - view[0, 3]
    y_m = (y - LENS.height / 2) / LENS.focal_px * depth - view[1, 3]
    label = np.where((np.abs(x_m) < 0.8) & (np.abs(y_m) < 0.8), 1, -1).astype(np.int32)
    return 100 + 20 * x_m + 30 * y_m, label


def slanted(view: F64, size: int) -> tuple[F64, F64, I32]:
    """As `ramp`, of a square whose depth grows by 2 m a metre to the right; and its depth."""
    x, y = grid(size)
    right, down = (x - LENS.width / 2) / LENS.focal_px, (y - LENS.height / 2) / LENS.focal_px
    depth = (view[2, 3] - 2 * view[0, 3]) / (1 - 2 * right)
    x_m, y_m = right * depth - view[0, 3], down * depth - view[1, 3]
    label = np.where((np.abs(x_m) < 0.8) & (np.abs(y_m) < 0.8), 1, -1).astype(np.int32)
    return 100 + 80 * x_m + 30 * y_m, depth, label


def test_at_edges_too_a_pattern_moves_as_far_as_its_depth_says() -> None:
    size, then, now = 3, at(-0.2), at(0.2)
    fine, _, label = slanted(then, size)
    seen = surfaces([fine, fine], [label, label], size, now, (then, then), 0.5)
    wanted, depth, label = slanted(now, size)
    nearness = np.where(label == 1, 1 / depth, 1 / STREET_M).astype(np.float32)
    street = flat_street(STREET_M, np.array([10.0]), size=size)
    image = composed(street, lights(1.0), seen, label, nearness)
    whole = to_pixels(np.where(label == 1, wanted, 10).astype(np.float32), size)
    np.testing.assert_allclose(image, whole, atol=1.5)


def test_what_no_keyframe_shows_takes_the_bodys_mean() -> None:
    label = shape("disc", 3)
    mover = even_mover(label, 90.0, 3)
    elsewhere = np.roll(label, 60, axis=1)
    street = flat_street(STREET_M, np.array([10.0]))
    image = composed(street, lights(1.0), mover, elsewhere, near(elsewhere))
    np.testing.assert_allclose(image[17, 50:53], 90, rtol=1e-4)


def test_a_wheel_takes_its_albedo_along_and_leaves_its_light() -> None:
    """The albedo is brighter to one side of the body, the light to one side of the vehicle."""
    size = 3
    x, y = grid(size)
    label = np.where((x - 30) ** 2 + (y - 20) ** 2 < 150, 1, -1).astype(np.int32)
    albedo = np.where(label == 1, 0.3 + 0.01 * (x - 30), 0).astype(np.float32)
    glow = (100 + 2 * (x - 30)).astype(np.float32)
    none = np.empty(0, np.int64)
    body = MovingObject("it", "box", 2, np.array([2, 1]), none, np.zeros((2, 3)), none)
    whole = np.full(label.shape, 1, np.int32)

    def draw(_: MovingObject, t_us: int) -> Keyframe:
        own = cut_pieces(albedo[None], label, {1: at()}, (0, 0), size, LENS_BLUR_PX, per_pixel=size)
        light = cut_pieces(glow[None], whole, {1: at()}, (0, 0), size, LENS_BLUR_PX, per_pixel=size)
        return Keyframe(t_us, own, light)

    carriers = np.arange(3, dtype=np.int32)
    store = KeyframeStore({"it": [0, 1000]}, (body,), draw, carriers=carriers, per_pixel=size)
    store.advance(500)
    half_turn = np.column_stack([np.diag([-1.0, -1.0, 1.0]), [0, 0, MOVER_M]])
    # The middle of the disc lies on the axis, so that it turns about itself.
    street = flat_street(STREET_M, np.array([10.0]), size=size)
    seen = store.surfaces(500, np.stack([np.eye(3, 4), half_turn, at()]), mains=1.0)
    image = composed(street, lights(1.0), seen, label, near(label))
    for off in (-8, -3, 0, 5, 9):
        middle = 30 + off
        wanted = (0.3 - 0.01 * (off + 0.5)) * (100 + 2 * (off + 0.5))
        assert image[20, middle] == pytest.approx(wanted, rel=0.01), off
