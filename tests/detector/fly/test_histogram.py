import numpy as np
import numpy.typing as npt
import pytest

from detector.fly.histogram import averaged_histogram
from detector.fly.model_variants import Averaging


def tallies(total: float, number: int) -> npt.NDArray[np.float64]:
    return np.full((1, 2, 1, 1, 2), [total, number], np.float64)


@pytest.mark.parametrize(
    ("averaging", "expected"),
    [
        (Averaging.EVENTS, 2.0),
        (Averaging.BOTH, 1.0),
        (Averaging.AREA, 6.0 / 9.0),
        (Averaging.NONE, 6.0),
    ],
)
def test_divides_by_the_chosen_divisor(averaging: Averaging, expected: float) -> None:
    mean = averaged_histogram(tallies(6.0, 3), averaging=averaging, cell_area=9)
    assert mean.dtype == np.float32
    np.testing.assert_allclose(mean, expected, rtol=1e-6)


def test_an_empty_cell_is_zero() -> None:
    for averaging in Averaging:
        assert averaged_histogram(tallies(0, 0), averaging=averaging, cell_area=9).max() == 0.0


def test_a_window_is_the_sum_of_its_hops_from_the_oldest() -> None:
    hops = np.random.default_rng(0).random((5, 2, 3, 4, 2))
    hops[..., 1] = 1.0
    total = averaged_histogram(hops, averaging=Averaging.NONE, cell_area=9)
    np.testing.assert_allclose(total, hops[..., 0].sum(axis=0), rtol=1e-6)
    for oldest in range(5):
        ring = np.roll(hops, oldest, axis=0)
        again = averaged_histogram(ring, oldest=oldest, averaging=Averaging.NONE, cell_area=9)
        np.testing.assert_array_equal(again, total)
