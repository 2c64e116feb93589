"""One sample's image of a background, movers and shadows whose image is known in closed form."""

import numpy as np
import pytest

from sim.raster.aperture import to_pixels
from tests.sim.flat_background import composited, effects, flat_background, half_plane_shadow
from tests.sim.keyframed_mover import (
    BACKGROUND_M,
    even_surface,
    label_of_shape,
    nearness_of,
    subpixel_grid,
    surfaces_between,
    view_at,
)

SIZES = [2, 3, 4]


@pytest.mark.parametrize("size", SIZES)
def test_without_movers_the_image_is_the_weighted_sum_of_the_layers(size: int) -> None:
    background = flat_background(BACKGROUND_M, np.array([3.0, 5.0, 11.0]), supersample=size)
    np.testing.assert_allclose(composited(background, effects(1.0, 1.0, 1.0)), 19, rtol=1e-6)
    np.testing.assert_allclose(composited(background, effects(1.0, 0.5, 2.0)), 27.5, rtol=1e-6)


@pytest.mark.parametrize("shape", ["left half", "disc", "stripe", "whole"])
@pytest.mark.parametrize("size", SIZES)
def test_a_mover_as_bright_as_the_background_is_invisible(shape: str, size: int) -> None:
    label = label_of_shape(shape, size)
    background = flat_background(BACKGROUND_M, np.array([20.0, 20.0]), supersample=size)
    surface = even_surface(label, 40.0, size)
    image = composited(background, effects(1.0, 1.0), surface, label, nearness_of(label))
    np.testing.assert_allclose(image, 40, rtol=1e-4)


@pytest.mark.parametrize("shape", ["left half", "upper half"])
@pytest.mark.parametrize("size", [2, 4])
def test_a_half_covered_pixel_has_the_mean_of_both_luminances(shape: str, size: int) -> None:
    label = label_of_shape(shape, size)
    background = flat_background(BACKGROUND_M, np.array([10.0]), supersample=size)
    surface = even_surface(label, 90.0, size)
    image = composited(background, effects(1.0), surface, label, nearness_of(label))
    half = image[:, 30] if shape == "left half" else image[20]
    inside, outside = (image[5, 5], image[35, 55])
    assert half == pytest.approx(50, rel=1e-4)
    assert inside == pytest.approx(90, rel=1e-4)
    assert outside == pytest.approx(10, rel=1e-4)


@pytest.mark.parametrize("size", SIZES)
def test_edges_are_weighted_with_the_aperture(size: int) -> None:
    label = label_of_shape("disc", size)
    background = flat_background(BACKGROUND_M, np.array([10.0]), supersample=size)
    surface = even_surface(label, 90.0, size)
    image = composited(background, effects(1.0), surface, label, nearness_of(label))
    wanted = to_pixels(np.where(label == 1, 90, 10).astype(np.float32), size)
    np.testing.assert_allclose(image, wanted, rtol=1e-4)


@pytest.mark.parametrize("shape", ["disc", "stripe"])
@pytest.mark.parametrize("size", SIZES)
def test_at_a_keyframe_a_pattern_is_reproduced_up_to_its_edges(shape: str, size: int) -> None:
    label, (x, y) = label_of_shape(shape, size), subpixel_grid(size)
    pattern = 300 + 5 * x - 6 * y
    views = view_at(), view_at()
    surfaces = surfaces_between([pattern, pattern], [label, label], size, view_at(), views, 0.5)
    background = flat_background(BACKGROUND_M, np.array([10.0]), supersample=size)
    image = composited(background, effects(1.0), surfaces, label, nearness_of(label))
    wanted = to_pixels(np.where(label == 1, pattern, 10).astype(np.float32), size)
    np.testing.assert_allclose(image[1:-1], wanted[1:-1], rtol=3e-3, atol=0.2)


@pytest.mark.parametrize("size", SIZES)
def test_a_rectangle_alone_is_composited_as_in_the_whole_image(size: int) -> None:
    label, (x, y) = label_of_shape("disc", size), subpixel_grid(size)
    background = flat_background(BACKGROUND_M, np.stack([10 + x, 5 + y]), supersample=size)
    shadow, surface = (
        effects(1.0, 1.0, **half_plane_shadow(30.5, 0)),
        even_surface(label, 90.0, size),
    )
    whole = composited(background, shadow, surface, label, nearness_of(label))
    x0, y0, x1, y1 = rectangle = (18, 3, 44, 30)
    part = np.s_[y0 * size : y1 * size, x0 * size : x1 * size]
    image = composited(
        background,
        shadow,
        surface,
        label[part].copy(),
        nearness_of(label)[part].copy(),
        rectangle=rectangle,
    )
    # The outermost pixels lack their outer neighbours; rectangles have a margin for this.
    inner = np.s_[y0 + 1 : y1 - 1, x0 + 1 : x1 - 1]
    np.testing.assert_allclose(image[inner], whole[inner], rtol=1e-6)
    image[y0:y1, x0:x1] = np.nan
    assert np.isnan(image).all()
