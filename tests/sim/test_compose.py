"""One sample's image by hand: street, movers and shadows that are known in closed form."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.aperture import LENS_BLUR_PX, to_pixels
from sim.compose import Surfaces
from sim.keyframes import Keyframe, KeyframeStore, cut_pieces
from sim.objects import MovingObject
from tests.sim.flat import LENS, composed, flat_street, lights

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]

STREET_M, MOVER_M = 10.0, 4.0
SIZES = [2, 3, 4]


def grid(size: int) -> tuple[F64, F64]:
    """x and y of the fine points [px]."""
    y, x = (np.mgrid[: LENS.height * size, : LENS.width * size] + 0.5) / size
    return x, y


def surfaces(
    fine: list[F64], labels: list[I32], size: int, now: F64, views: tuple[F64, F64], late: float
) -> Surfaces:
    """Body 1 as two keyframes show it, 1000 µs apart; `views` are its poses there."""
    none = np.empty(0, np.int64)
    body = MovingObject("it", "box", 1, np.array([1]), none, np.zeros((2, 3)), none)

    def draw(_: MovingObject, t_us: int) -> Keyframe:
        k = t_us // 1000
        points = fine[k].astype(np.float32)[None]
        return Keyframe(
            t_us, cut_pieces(points, labels[k], {1: views[k]}, (0, 0), size, LENS_BLUR_PX)
        )

    store = KeyframeStore(
        {"it": [0, 1000]}, (body,), draw, carriers=np.arange(2, dtype=np.int32), per_pixel=size
    )
    t_us = round(1000 * late)
    store.advance(t_us)
    return store.surfaces(t_us, np.stack([np.eye(3, 4), now]), mains=1.0)


def at(x_m: float = 0.0, y_m: float = 0.0, z_m: float = MOVER_M) -> F64:
    return np.column_stack([np.eye(3), [x_m, y_m, z_m]])


def even_mover(label: I32, luminance: float, size: int) -> Surfaces:
    """Body 1 at rest, equally bright."""
    fine = np.where(label == 1, luminance, 7e4)
    return surfaces([fine, fine], [label, label], size, at(), (at(), at()), 0.5)


def shape(kind: str, size: int) -> I32:
    x, y = grid(size)
    inside = {
        "left half": x < 30.5,
        "upper half": y < 20.5,
        "disc": (x - 31) ** 2 + (y - 17) ** 2 < 90,
        "stripe": np.abs(x - 30 + 0.3 * y) < 0.4,
        "whole": x < 1e9,
    }[kind]
    return np.where(inside, 1, -1).astype(np.int32)


def near(label: I32) -> F32:
    return np.where(label >= 0, 1 / MOVER_M, 1 / STREET_M).astype(np.float32)


@pytest.mark.parametrize("size", SIZES)
def test_without_movers_the_street_is_the_sum_of_its_parts(size: int) -> None:
    street = flat_street(STREET_M, np.array([3.0, 5.0, 11.0]), size=size)
    np.testing.assert_allclose(composed(street, lights(1.0, 1.0, 1.0)), 19, rtol=1e-6)
    np.testing.assert_allclose(composed(street, lights(1.0, 0.5, 2.0)), 27.5, rtol=1e-6)


@pytest.mark.parametrize("kind", ["left half", "disc", "stripe", "whole"])
@pytest.mark.parametrize("size", SIZES)
def test_a_mover_as_bright_as_the_street_is_not_seen(kind: str, size: int) -> None:
    label = shape(kind, size)
    street = flat_street(STREET_M, np.array([20.0, 20.0]), size=size)
    image = composed(street, lights(1.0, 1.0), even_mover(label, 40.0, size), label, near(label))
    np.testing.assert_allclose(image, 40, rtol=1e-4)


@pytest.mark.parametrize("kind", ["left half", "upper half"])
@pytest.mark.parametrize("size", [2, 4])
def test_a_mover_that_covers_half_a_pixel_gives_half_its_light(kind: str, size: int) -> None:
    label = shape(kind, size)
    street = flat_street(STREET_M, np.array([10.0]), size=size)
    image = composed(street, lights(1.0), even_mover(label, 90.0, size), label, near(label))
    half = image[:, 30] if kind == "left half" else image[20]
    inside, outside = (image[5, 5], image[35, 55])
    assert half == pytest.approx(50, rel=1e-4)
    assert inside == pytest.approx(90, rel=1e-4)
    assert outside == pytest.approx(10, rel=1e-4)


@pytest.mark.parametrize("size", SIZES)
def test_edges_are_seen_through_the_aperture(size: int) -> None:
    label = shape("disc", size)
    street = flat_street(STREET_M, np.array([10.0]), size=size)
    image = composed(street, lights(1.0), even_mover(label, 90.0, size), label, near(label))
    wanted = to_pixels(np.where(label == 1, 90, 10).astype(np.float32), size)
    np.testing.assert_allclose(image, wanted, rtol=1e-4)


@pytest.mark.parametrize("kind", ["disc", "stripe"])
@pytest.mark.parametrize("size", SIZES)
def test_at_a_keyframe_a_pattern_is_as_drawn_up_to_its_edges(kind: str, size: int) -> None:
    label, (x, y) = shape(kind, size), grid(size)
    fine = 300 + 5 * x - 6 * y
    seen = surfaces([fine, fine], [label, label], size, at(), (at(), at()), 0.5)
    street = flat_street(STREET_M, np.array([10.0]), size=size)
    image = composed(street, lights(1.0), seen, label, near(label))
    wanted = to_pixels(np.where(label == 1, fine, 10).astype(np.float32), size)
    np.testing.assert_allclose(image[1:-1], wanted[1:-1], rtol=3e-3, atol=0.2)


@pytest.mark.parametrize("size", SIZES)
def test_a_window_is_composed_alone_and_as_in_the_whole(size: int) -> None:
    label, (x, y) = shape("disc", size), grid(size)
    street = flat_street(STREET_M, np.stack([10 + x, 5 + y]), size=size)
    mover, light = even_mover(label, 90.0, size), lights(1.0, 1.0, **half_shadow(30.5, 0))
    whole = composed(street, light, mover, label, near(label))
    x0, y0, x1, y1 = window = (18, 3, 44, 30)
    part = np.s_[y0 * size : y1 * size, x0 * size : x1 * size]
    image = composed(
        street, light, mover, label[part].copy(), near(label)[part].copy(), window=window
    )
    # At its border it does not know what lies beyond; windows have a margin for that.
    inner = np.s_[y0 + 1 : y1 - 1, x0 + 1 : x1 - 1]
    np.testing.assert_allclose(image[inner], whole[inner], rtol=1e-6)
    image[y0:y1, x0:x1] = np.nan
    assert np.isnan(image).all()


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


def half_shadow(edge_px: float, light: int) -> dict[str, npt.NDArray[np.generic]]:
    """A shadow in parallel light along the view: dark left of a column of the street."""
    texels_m = 80.0  # a metre, so that a pixel of the street, 0.2 m, is 16
    maps = np.full((1, 700, 1020), -np.inf, np.float32)
    column = round((edge_px - LENS.width / 2) / LENS.focal_px * STREET_M * texels_m) + 510
    maps[0, :, :column] = 0.0
    view = np.array([[texels_m, 0, 0, 510], [0, texels_m, 0, 350], [0, 0, -1, 0]])
    return {
        "maps": maps,
        "sizes": np.array([[700, 1020]]),
        "views": view[None],
        "light": np.array([light]),
        "parallel": np.array([True]),
        "reach": np.array([[0, 0, LENS.width, LENS.height]]),
    }


@pytest.mark.parametrize(("light", "dark", "half"), [(0, 11.0, 11.5), (1, 3.0, 7.5)])
@pytest.mark.parametrize("size", [2, 4])
def test_a_shadow_takes_its_own_lamps_light_and_half_of_it_at_its_edge(
    light: int, dark: float, half: float, size: int
) -> None:
    street = flat_street(STREET_M, np.array([1.0, 2.0, 3.0]), size=size)
    image = composed(street, lights(2.0, 0.5, 3.0, **half_shadow(30.5, light)))
    np.testing.assert_allclose(image[:, 2:28], dark, rtol=1e-5)
    np.testing.assert_allclose(image[:, 33:], 12, rtol=1e-5)
    np.testing.assert_allclose(image[:, 30], half, rtol=0.02)
    assert (np.diff(image[:, 2:], axis=1) >= -1e-5).all()


@pytest.mark.parametrize("edge_px", [30.0, 30.25, 30.5, 30.75])
def test_a_shadows_edge_is_seen_through_the_aperture(edge_px: float) -> None:
    street = flat_street(STREET_M, np.array([1.0, 2.0]), size=4)
    image = composed(street, lights(1.0, 1.0, **half_shadow(edge_px, 0)))
    x, _ = grid(4)
    wanted = to_pixels(np.where(x < edge_px, 1, 3).astype(np.float32), 4)
    # The blur's last percent is left out where all around a pixel its middles are lit alike.
    np.testing.assert_allclose(image, wanted, atol=3e-3)


def test_a_shadow_ends_with_its_reach() -> None:
    street = flat_street(STREET_M, np.array([1.0, 2.0]))
    shadow = half_shadow(30.5, 0) | {"reach": np.array([[0, 10, 60, 20]])}
    image = composed(street, lights(1.0, 1.0, **shadow))
    np.testing.assert_allclose(image[:8], 3, rtol=1e-6)
    np.testing.assert_allclose(image[12:18, 2:28], 1, rtol=1e-5)


@pytest.mark.parametrize("edges_px", [(30.5, 30.5), (30.5, 14.5), (14.5, 30.5)])
def test_two_shadows_in_one_light_darken_it_once(edges_px: tuple[float, float]) -> None:
    street = flat_street(STREET_M, np.array([1.0, 2.0]))
    one, other = (half_shadow(edge, 0) for edge in edges_px)
    both = {name: np.concatenate([one[name], other[name]]) for name in one}
    image = composed(street, lights(1.0, 1.0, **both))
    np.testing.assert_allclose(image[:, 2:28], 1, rtol=1e-5)
    np.testing.assert_allclose(image[:, 30], 2, rtol=0.1)
    np.testing.assert_allclose(image[:, 33:], 3, rtol=1e-6)


def test_shadows_do_not_fall_on_what_stands_before_the_street() -> None:
    label = shape("upper half", 3)
    street = flat_street(STREET_M, np.array([1.0, 2.0]))
    image = composed(
        street,
        lights(1.0, 1.0, **half_shadow(30.5, 0)),
        even_mover(label, 90.0, 3),
        label,
        near(label),
    )
    np.testing.assert_allclose(image[:18], 90, rtol=1e-4)
    np.testing.assert_allclose(image[23:, 2:28], 1, rtol=1e-5)


def test_the_streets_pattern_is_kept_where_points_are_weighed() -> None:
    """Beside an edge pixels are made of points, elsewhere taken as they are: no seam between."""
    size = 3
    x, y = grid(size)
    fine = np.stack([50 + 20 * np.sin(2 * x) * np.cos(3 * y), 0 * x]).astype(np.float32)
    street = flat_street(STREET_M, fine, size=size)
    pixels = np.stack([to_pixels(part, size) for part in fine])
    street = street._replace(pixels=pixels)
    image = composed(street, lights(1.0, 1.0, **half_shadow(30.5, 0)))
    np.testing.assert_allclose(image[1:-1, 1:-1], pixels[0, 1:-1, 1:-1], rtol=1e-4)


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
        own = cut_pieces(albedo[None], label, {1: at()}, (0, 0), size, LENS_BLUR_PX)
        light = cut_pieces(glow[None], whole, {1: at()}, (0, 0), size, LENS_BLUR_PX)
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
