"""Where shadows fall on the street, and where not."""

import numpy as np

from tests.sim.flat import composed, flat_street, half_shadow, lights
from tests.sim.flat_movers import STREET_M, even_mover, near, shape


def test_a_shadow_ends_with_its_reach() -> None:
    street = flat_street(STREET_M, np.array([1.0, 2.0]))
    shadow = half_shadow(30.5, 0) | {"reach": np.array([[0, 10, 60, 20]])}
    image = composed(street, lights(1.0, 1.0, **shadow))
    np.testing.assert_allclose(image[:8], 3, rtol=1e-6)
    np.testing.assert_allclose(image[12:18, 2:28], 1, rtol=1e-5)


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
