"""Where shadows fall on the background, and where they do not."""

import numpy as np

from tests.sim.flat_background import composited, effects, flat_background, half_plane_shadow
from tests.sim.keyframed_mover import BACKGROUND_M, even_surface, label_of_shape, nearness_of


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
