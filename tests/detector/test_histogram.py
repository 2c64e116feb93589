import numpy as np
import pytest

from detector.histogram import Averaging, averaged_histogram, window_sums


@pytest.mark.parametrize(
    ("averaging", "expected"),
    [(Averaging.EVENTS, 2.0), (Averaging.AREA, 6.0 / 9.0), (Averaging.NONE, 6.0)],
)
def test_divides_by_what_it_says(averaging: Averaging, expected: float) -> None:
    sums, counts = np.full((2, 1, 1), 6.0), np.full((2, 1, 1), 3, np.int64)
    mean = averaged_histogram(sums, counts, averaging=averaging, cell_area=9)
    assert mean.dtype == np.float32
    np.testing.assert_allclose(mean, expected, rtol=1e-6)


def test_an_empty_cell_is_zero() -> None:
    nothing = np.zeros((2, 1, 1)), np.zeros((2, 1, 1), np.int64)
    assert averaged_histogram(*nothing, averaging=Averaging.EVENTS, cell_area=9).max() == 0.0


def test_a_window_adds_only_its_hops() -> None:
    sums = np.arange(4.0).reshape(4, 1, 1, 1)
    total, number = window_sums(sums, np.ones((4, 1, 1, 1), np.int64), np.array([3, 1]))
    assert (total.item(), number.item()) == (4.0, 2)
