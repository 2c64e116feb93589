"""Where shadows fall on the background, and its luminance at their edges, in closed form."""

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
)


@pytest.mark.parametrize(("light", "dark", "half"), [(0, 11.0, 11.5), (1, 3.0, 7.5)])
@pytest.mark.parametrize("size", [2, 4])
def test_a_shadow_removes_only_its_own_light_and_half_of_it_at_its_edge(
    light: int, dark: float, half: float, size: int
) -> None:
    background = flat_background(BACKGROUND_M, np.array([1.0, 2.0, 3.0]), supersample=size)
    image = composited(background, effects(2.0, 0.5, 3.0, **half_plane_shadow(30.5, light)))
    np.testing.assert_allclose(image[:, 2:28], dark, rtol=1e-5)
    np.testing.assert_allclose(image[:, 33:], 12, rtol=1e-5)
    np.testing.assert_allclose(image[:, 30], half, rtol=0.02)
    assert (np.diff(image[:, 2:], axis=1) >= -1e-5).all()


@pytest.mark.parametrize("edge_px", [30.0, 30.25, 30.5, 30.75])
def test_a_shadows_edge_is_weighted_with_the_aperture(edge_px: float) -> None:
    background = flat_background(BACKGROUND_M, np.array([1.0, 2.0]), supersample=4)
    image = composited(background, effects(1.0, 1.0, **half_plane_shadow(edge_px, 0)))
    x, _ = subpixel_grid(4)
    wanted = to_pixels(np.where(x < edge_px, 1, 3).astype(np.float32), 4)
    # The blur's last percent is neglected where a pixel and its neighbours are evenly lit.
    np.testing.assert_allclose(image, wanted, atol=3e-3)


@pytest.mark.parametrize("edges_px", [(30.5, 30.5), (30.5, 14.5), (14.5, 30.5)])
def test_two_shadows_of_one_light_remove_it_only_once(edges_px: tuple[float, float]) -> None:
    background = flat_background(BACKGROUND_M, np.array([1.0, 2.0]))
    one, other = (half_plane_shadow(edge, 0) for edge in edges_px)
    both = {name: np.concatenate([one[name], other[name]]) for name in one}
    image = composited(background, effects(1.0, 1.0, **both))
    np.testing.assert_allclose(image[:, 2:28], 1, rtol=1e-5)
    np.testing.assert_allclose(image[:, 30], 2, rtol=0.1)
    np.testing.assert_allclose(image[:, 33:], 3, rtol=1e-6)


def test_there_is_no_seam_between_subpixel_and_pixel_shading() -> None:
    size = 3
    x, y = subpixel_grid(size)
    layers = np.stack([50 + 20 * np.sin(2 * x) * np.cos(3 * y), 0 * x]).astype(np.float32)
    background = flat_background(BACKGROUND_M, layers, supersample=size)
    pixels = np.stack([to_pixels(layer, size) for layer in layers])
    background = background._replace(pixels=pixels)
    image = composited(background, effects(1.0, 1.0, **half_plane_shadow(30.5, 0)))
    np.testing.assert_allclose(image[1:-1, 1:-1], pixels[0, 1:-1, 1:-1], rtol=1e-4)


def test_a_fully_lit_background_is_that_of_the_static_image_up_to_the_border() -> None:
    """The shadow's map covers the rectangle, but no shadow falls into it."""
    size = 3
    layers = np.random.default_rng(0).uniform(1, 3, (2, 40 * size, 60 * size)).astype(np.float32)
    background = flat_background(BACKGROUND_M, layers, supersample=size)
    pixels = np.stack([to_pixels(layer, size) for layer in layers])
    background = background._replace(pixels=pixels)
    shadow = half_plane_shadow(10.0, 0)
    shadow["views"] = np.multiply(1.037, shadow["views"])  # points between texels
    x0, y0, x1, y1 = rectangle = (20, 5, 50, 30)
    image = composited(background, effects(1.0, 1.0, **shadow), rectangle=rectangle)
    wanted = pixels.sum(axis=0)[y0:y1, x0:x1]
    np.testing.assert_allclose(image[y0:y1, x0:x1], wanted, rtol=1e-6)


def test_a_shadow_is_confined_to_its_area() -> None:
    background = flat_background(BACKGROUND_M, np.array([1.0, 2.0]))
    shadow = half_plane_shadow(30.5, 0) | {"shadow_areas": np.array([[0, 10, 60, 20]])}
    image = composited(background, effects(1.0, 1.0, **shadow))
    np.testing.assert_allclose(image[:8], 3, rtol=1e-6)
    np.testing.assert_allclose(image[12:18, 2:28], 1, rtol=1e-5)


def test_shadows_do_not_fall_on_movers() -> None:
    label = label_of_shape("upper half", 3)
    background = flat_background(BACKGROUND_M, np.array([1.0, 2.0]))
    image = composited(
        background,
        effects(1.0, 1.0, **half_plane_shadow(30.5, 0)),
        even_surface(label, 90.0, 3),
        label,
        nearness_of(label),
    )
    np.testing.assert_allclose(image[:18], 90, rtol=1e-4)
    np.testing.assert_allclose(image[23:, 2:28], 1, rtol=1e-5)
