import numpy as np
import pytest

from flybench.portable_math import EXP_RANGE, exp, log, short_exp


def test_the_exponential_has_the_documented_precision() -> None:
    x = np.linspace(-60.0, 60.0, 20_001)
    assert np.array([exp(v) for v in x]) == pytest.approx(np.exp(x), rel=3e-13)


def test_the_short_exponential_has_the_documented_precision() -> None:
    x = np.linspace(-60.0, 60.0, 20_001)
    assert np.array([short_exp(v) for v in x]) == pytest.approx(np.exp(x), rel=1.8e-7)


@pytest.mark.parametrize("x", [-1e300, -np.inf, -5000.0])
def test_the_exponential_of_a_very_small_number_is_very_small(x: float) -> None:
    assert 0.0 < exp(x) <= 1.1 * np.exp(-EXP_RANGE)


def test_the_logarithm_has_the_documented_precision() -> None:
    x = np.exp(np.linspace(-60.0, 60.0, 20_001))
    assert np.array([log(v) for v in x]) == pytest.approx(np.log(x), abs=2e-14, rel=1e-15)
    assert log(1.0) == 0.0
