"""One sample's image by hand: street, movers and shadows that are known in closed form."""

import numpy as np
import pytest

from sim.raster.aperture import to_pixels
from tests.sim.flat import composed, flat_street, half_shadow, lights
from tests.sim.flat_movers import STREET_M, at, even_mover, grid, near, shape, surfaces

SIZES = [2, 3, 4]


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
    x0, y0, x1, y1 = rectangle = (18, 3, 44, 30)
    part = np.s_[y0 * size : y1 * size, x0 * size : x1 * size]
    image = composed(
        street, light, mover, label[part].copy(), near(label)[part].copy(), rectangle=rectangle
    )
    # At its border it does not know what lies beyond; rectangles have a margin for that.
    inner = np.s_[y0 + 1 : y1 - 1, x0 + 1 : x1 - 1]
    np.testing.assert_allclose(image[inner], whole[inner], rtol=1e-6)
    image[y0:y1, x0:x1] = np.nan
    assert np.isnan(image).all()
