"""How often noise reaches a threshold: the hazard of a Gaussian process with drift.

The noise has unit variance and correlation time 1, and the threshold is h away. While h is
constant, the process that has not yet crossed loses ν(h) of its share per unit of time: the decay
rate of an Ornstein-Uhlenbeck process that is absorbed at h, the smallest root of the parabolic
cylinder function D_ν(−h). If the threshold approaches, it also loses −h'·φ(h)/Φ(h). Their sum is
the hazard of Chizhov and Graham (Phys. Rev. E 75, 2007); the polynomials here are fits to the exact
functions.
"""

from __future__ import annotations

import math

from flybench.kernels import inlined
from flybench.portable_math import fma, short_exp

H_MIN, H_MAX = -3.0, 7.0
"""Range of the fits. Farther away there is no noise; nearer, the crossing is certain."""

_SLOPE = 3.2831
"""Slope of −ln Φ(h) at −3, with the sign changed."""

_FASTEST = 5.3495
"""ν(−3)."""

_PER_ROOT_2_PI = 1.0 / math.sqrt(2.0 * math.pi)


@inlined
def decay_rate(h: float) -> float:
    """Return ν(h) with an error of at most 1.2 %, for h in [−3, 7]; h outside is clipped."""
    x = min(max(h, H_MIN), H_MAX)
    series = fma(x, -1.87233e-5, 2.41440615e-4)
    series = fma(x, series, -5.82386e-5)
    series = fma(x, series, -0.00684182335)
    series = fma(x, series, -0.0233844186)
    series = fma(x, series, -0.112224174)
    series = fma(x, series, -0.794549704)
    return short_exp(fma(x, series, -0.00492648518))


@inlined
def sojourn(h: float) -> float:
    """Return the integral of ν from h to infinity, with an error of at most 2 %.

    While h moves steadily from h1 to h2, noise crosses at the mean rate (G(h1) − G(h2))/(h2 − h1),
    if G is this integral. Beyond 7 it is constant; below −3, ν is.
    """
    x = min(max(h, H_MIN), H_MAX)
    series = fma(x, -1.02641321e-5, 1.15771229e-4)
    series = fma(x, series, 2.52807766e-4)
    series = fma(x, series, -0.00453870521)
    series = fma(x, series, -0.0274020331)
    series = fma(x, series, -0.144076264)
    series = fma(x, series, -1.06377182)
    return short_exp(fma(x, series, -0.0722817546)) + max(H_MIN - h, 0.0) * _FASTEST


@inlined
def surprise(h: float) -> float:
    """Return −ln Φ(h), with Φ the normal distribution, with an error of at most 1.2 % below h = 7.

    Beyond 7 it is constant. Below −3 it continues as a parabola.
    """
    x = min(max(h, H_MIN), H_MAX)
    series = fma(x, -4.22588e-5, 6.52297e-4)
    series = fma(x, series, -0.00101146)
    series = fma(x, series, -0.035826393)
    series = fma(x, series, -0.209993314)
    series = fma(x, series, -1.14428553)
    beyond = max(H_MIN - h, 0.0)
    return short_exp(fma(x, series, -0.36291971)) + beyond * (_SLOPE + 0.5 * beyond)


@inlined
def surprise_slope(h: float) -> float:
    """Return φ(h)/Φ(h), with φ the density of the normal distribution: minus the slope of −ln Φ."""
    x = min(max(h, H_MIN), H_MAX)
    return _PER_ROOT_2_PI * short_exp(surprise(x) - 0.5 * x * x) + max(H_MIN - h, 0.0)
