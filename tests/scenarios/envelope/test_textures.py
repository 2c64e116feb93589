from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from scenarios.envelope.textures import crown, leaves, panels, saloon, street, stripes


@pytest.mark.parametrize("make", [panels, street, leaves])
def test_contrast_is_the_standard_deviation(make: Callable[..., Any]) -> None:
    image = make((48, 120), contrast=0.3, rng=np.random.default_rng(1))
    assert image.shape == (48, 120)
    assert image.dtype == np.float32
    assert image.std() == pytest.approx(0.3, rel=1e-4)
    assert image.mean() == pytest.approx(0.0, abs=1e-4)
    other = make((48, 120), contrast=0.3, rng=np.random.default_rng(2))
    assert not np.array_equal(image, other)


def test_stripes_run_across_the_way() -> None:
    image = stripes((10, 48), contrast=0.5)
    assert (np.ptp(image, axis=0) == 0).all()
    np.testing.assert_allclose(image[0, 24:], image[0, :24])
    np.testing.assert_allclose(image[0, 12:24], -image[0, :12])


def test_a_saloon_has_a_body_wheels_and_air_around_it() -> None:
    paint, cover = saloon((48, 120), contrast=0.8)
    assert paint[cover == 1].std() == pytest.approx(0.8, rel=1e-4)
    assert set(np.unique(cover)) == {0.0, 1.0}
    assert cover[0, 0] == cover[0, -1] == cover[-1, 60] == 0
    assert cover[30].all()
    assert paint[15, 50] < 0 < paint[28, 50]  # glass over body
    assert (paint[cover == 0] == 0).all()


def test_a_crown_is_round_and_ragged() -> None:
    cover = crown(40, rng=np.random.default_rng(0))
    assert cover[20, 20] == 1
    assert cover[0, 0] == cover[-1, -1] == 0
    assert 0.4 < cover.mean() < np.pi / 4
