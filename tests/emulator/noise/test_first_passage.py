"""The polynomials against the exact functions."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import pbdv
from scipy.stats import norm

from emulator.noise.first_passage import decay_rate, sojourn, surprise, surprise_slope


def exact_decay_rate(h: float) -> float:
    """Return the smallest positive root ν of the parabolic cylinder function D_ν(−h)."""
    grid = np.concatenate((np.geomspace(1e-13, 0.5, 200), np.linspace(0.51, 8.0, 200)))
    values = np.array([pbdv(nu, -h)[0] for nu in grid])
    first = int(np.flatnonzero(np.sign(values[1:]) != np.sign(values[:-1]))[0])
    low, high = float(grid[first]), float(grid[first + 1])
    return float(brentq(lambda nu: pbdv(nu, -h)[0], low, high, xtol=1e-20, rtol=1e-10))


@pytest.mark.parametrize("h", [-3.0, -1.7, -0.4, 0.3, 1.0, 2.2, 3.1, 4.0, 5.2, 6.1, 7.0])
def test_the_decay_rate_is_the_root_of_the_parabolic_cylinder_function(h: float) -> None:
    assert decay_rate(h) == pytest.approx(exact_decay_rate(h), rel=0.0125)


@pytest.mark.parametrize("h", [-5.0, -2.5, -1.7, -0.4, 0.3, 1.0, 2.2, 3.1, 4.0, 5.2, 6.1, 6.9])
def test_the_sojourn_is_the_integral_of_the_decay_rate(h: float) -> None:
    slope = (sojourn(h - 1e-4) - sojourn(h + 1e-4)) / 2e-4
    assert slope == pytest.approx(exact_decay_rate(max(h, -3.0)), rel=0.02)
    expected = quad(decay_rate, h, 7.0, epsabs=1e-16)[0] + sojourn(7.0)
    assert sojourn(h) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("h", np.linspace(-3.0, 7.0, 21))
def test_surprise_is_minus_the_logarithm_of_the_normal_distribution(h: float) -> None:
    assert surprise(h) == pytest.approx(-norm.logcdf(h), rel=0.0125)


def test_nearer_than_the_fits_a_crossing_only_becomes_more_certain() -> None:
    h = np.linspace(-9.0, -3.0, 25)
    assert np.all(np.diff([surprise(x) for x in h]) < 0.0)
    assert surprise(-6.0) == pytest.approx(-norm.logcdf(-6.0), rel=0.05)


def test_farther_away_noise_does_not_count() -> None:
    assert surprise(7.0) < 2e-12
    assert decay_rate(12.0) == decay_rate(7.0) < 1e-10


@pytest.mark.parametrize("h", [-50.0, -2.0, -1.0, 0.0, 2.0, 5.0])
def test_the_slope_is_that_of_the_surprise(h: float) -> None:
    numeric = (surprise(h - 1e-5) - surprise(h + 1e-5)) / 2e-5
    assert surprise_slope(h) == pytest.approx(numeric, rel=0.07)
    assert surprise_slope(h) == pytest.approx(math.exp(norm.logpdf(h) - norm.logcdf(h)), rel=0.05)
