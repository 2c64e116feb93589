"""The street's light at shadows' edges, known in closed form."""

import numpy as np
import pytest

from sim.raster.aperture import to_pixels
from tests.sim.flat import composed, flat_street, half_shadow, lights
from tests.sim.flat_movers import STREET_M, grid


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


@pytest.mark.parametrize("edges_px", [(30.5, 30.5), (30.5, 14.5), (14.5, 30.5)])
def test_two_shadows_in_one_light_darken_it_once(edges_px: tuple[float, float]) -> None:
    street = flat_street(STREET_M, np.array([1.0, 2.0]))
    one, other = (half_shadow(edge, 0) for edge in edges_px)
    both = {name: np.concatenate([one[name], other[name]]) for name in one}
    image = composed(street, lights(1.0, 1.0, **both))
    np.testing.assert_allclose(image[:, 2:28], 1, rtol=1e-5)
    np.testing.assert_allclose(image[:, 30], 2, rtol=0.1)
    np.testing.assert_allclose(image[:, 33:], 3, rtol=1e-6)


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
