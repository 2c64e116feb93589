import numpy as np
import pytest

from detector.space_time_filters.filters import (
    SUPPORT,
    biphasic,
    gabor,
    monophasic,
    mu_of_speed,
    preferred_frequency,
)

T = np.arange(0.0, SUPPORT, 0.001)


def test_the_monophasic_filter_peaks_where_the_biphasic_is_zero() -> None:
    peak = int(np.argmax(monophasic(T, 1.0)))
    assert biphasic(T, 1.0)[peak] == pytest.approx(0.0, abs=2e-3)
    assert biphasic(T, 1.0).min() == pytest.approx(-0.5, abs=0.1)
    assert biphasic(T, 1.0).max() == pytest.approx(0.75, abs=0.02)


def test_the_filters_are_over_after_their_support() -> None:
    late = np.array([SUPPORT, 10.0])
    assert np.abs(monophasic(late, 1.0)).max() < 1e-5
    assert np.abs(biphasic(late, 1.0)).max() < 0.01


@pytest.mark.parametrize(
    ("frequency", "mu_s", "speed_px_s"),
    [(0.08, 0.2, 12.17), (0.04, 0.05, 100.65), (0.10, 0.45, 4.33), (0.06, 0.10, 32.55)],
)
def test_the_preferred_speed_is_that_of_the_papers_table_1(
    frequency: float, mu_s: float, speed_px_s: float
) -> None:
    assert preferred_frequency(mu_s) / frequency == pytest.approx(speed_px_s, rel=0.04)
    assert mu_of_speed(speed_px_s, frequency) == pytest.approx(mu_s, rel=0.04)


def test_the_gabor_filter_is_the_papers() -> None:
    # Equation 20 at (5, −3) px, with a frequency vector of (0.04, 0.07).
    x, y, sigma = 5.0, -3.0, 25.0
    wave = np.exp(2j * np.pi * (0.04 * x + 0.07 * y))
    expected = 2 * np.pi / sigma**2 * wave * np.exp(-2 * np.pi**2 * (x**2 + y**2) / sigma**2)
    product = gabor(np.array(x), 0.04, sigma) * gabor(np.array(y), 0.07, sigma)
    assert product == pytest.approx(expected)
