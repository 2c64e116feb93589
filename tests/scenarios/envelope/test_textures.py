"""Textures of synthetic stimuli."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from scenarios.envelope.textures import (
    foliage,
    panels,
    saloon_car,
    smooth_background,
    stripes,
    tree_crown,
)


@pytest.mark.parametrize("make", [panels, smooth_background, foliage])
def test_contrast_is_the_standard_deviation(make: Callable[..., Any]) -> None:
    image = make((48, 120), contrast=0.3, rng=np.random.default_rng(1))
    assert image.shape == (48, 120)
    assert image.dtype == np.float32
    assert image.std() == pytest.approx(0.3, rel=1e-4)
    assert image.mean() == pytest.approx(0.0, abs=1e-4)
    other = make((48, 120), contrast=0.3, rng=np.random.default_rng(2))
    assert not np.array_equal(image, other)


def test_stripes_are_vertical_and_periodic() -> None:
    image = stripes((10, 48), contrast=0.5)
    assert (np.ptp(image, axis=0) == 0).all()
    np.testing.assert_allclose(image[0, 24:], image[0, :24])
    np.testing.assert_allclose(image[0, 12:24], -image[0, :12])


def test_a_saloon_car_is_opaque_and_its_surroundings_are_transparent() -> None:
    texture, opacity = saloon_car((48, 120), contrast=0.8)
    assert texture[opacity == 1].std() == pytest.approx(0.8, rel=1e-4)
    assert set(np.unique(opacity)) == {0.0, 1.0}
    assert opacity[0, 0] == opacity[0, -1] == opacity[-1, 60] == 0
    assert opacity[30].all()
    assert texture[15, 50] < 0 < texture[28, 50]  # glass over body
    assert (texture[opacity == 0] == 0).all()


def test_a_crown_is_round_and_ragged() -> None:
    opacity = tree_crown(40, rng=np.random.default_rng(0))
    assert opacity[20, 20] == 1
    assert opacity[0, 0] == opacity[-1, -1] == 0
    assert 0.4 < opacity.mean() < np.pi / 4
