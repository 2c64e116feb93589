import numpy as np
import pytest
from scipy.stats import spearmanr

from scenarios.velocity_sweep.rank_correlation import rank_correlation


@pytest.mark.parametrize(
    ("second", "expected"),
    [([0.1, 0.2, 0.4, 0.8], 1.0), ([9, 6, 3, 1], -1.0), ([1, 3, 2, 4], 0.8)],
)
def test_known_correlations(second: list[float], expected: float) -> None:
    assert rank_correlation([1.2, 1.6, 2.0, 2.4], second) == pytest.approx(expected)


@pytest.mark.parametrize("seed", range(20))
def test_it_agrees_with_scipy_also_with_equal_values(seed: int) -> None:
    first, second = np.random.default_rng(seed).integers(0, 6, (2, 9)).tolist()
    assert rank_correlation(first, second) == pytest.approx(spearmanr(first, second).statistic)
