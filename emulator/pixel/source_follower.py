"""The source follower behind the photoreceptor: an option that makes the pixel second order.

The follower's output w follows the photoreceptor's v through τ2·dw/dt = v − w, with τ2 set by its
bias and not by light (Lichtsteiner, Posch, Delbruck 2008; Graça, Delbruck 2021). With the lag
l = u − v, the photoreceptor's τ1, and the slope r of u, the second lag m = v − w is, exactly,

    m(s) = r·τ2 + K·exp(−s/τ1) + (m(0) − r·τ2 − K)·exp(−s/τ2),  K = (l(0) − r·τ1)·τ2/(τ1 − τ2)

so the difference to the memorised value is a line and two exponentials, which turns twice at most.
"""

from __future__ import annotations

from emulator.pixel.change_detector import NEVER_US
from flybench.kernels import compiled
from flybench.portable_math import exp, log

_ALIKE = 1e-3
"""Relative difference of τ1 and τ2 below which τ2 is taken to be that much longer than τ1: the
closed form has a removable singularity where they are equal."""

_HALVINGS = 50


@compiled
def unlike(tau_us: float, follower_us: float) -> float:
    """τ2, moved off τ1 where the two are alike."""
    if abs(follower_us - tau_us) < _ALIKE * tau_us:
        return tau_us * (1.0 + _ALIKE)
    return follower_us


@compiled
def amplitudes(
    lag: float, behind: float, slope: float, tau_us: float, follower_us: float
) -> tuple[float, float]:
    """Amplitudes of the two exponentials in the course of w, for τ1 and for τ2.

    Args:
        lag: u − v at the start.
        behind: v − w at the start.
        slope: of u [1/µs].
        tau_us: τ1 [µs].
        follower_us: τ2, unlike τ1 [µs].
    """
    first = lag - slope * tau_us
    coupling = first * follower_us / (tau_us - follower_us)
    return first + coupling, behind - slope * follower_us - coupling


@compiled
def behind_after(
    lag: float, behind: float, slope: float, tau_us: float, follower_us: float, span_us: float
) -> float:
    """Second lag v − w after a ramp of `slope` per µs for `span_us`."""
    follower_us = unlike(tau_us, follower_us)
    first = lag - slope * tau_us
    coupling = first * follower_us / (tau_us - follower_us)
    own = behind - slope * follower_us - coupling
    decay, decay_2 = exp(-span_us / tau_us), exp(-span_us / follower_us)
    return slope * follower_us + coupling * decay + own * decay_2


@compiled
def course(
    level: float, rate: float, a: float, b: float, tau_us: float, follower_us: float, s_us: float
) -> float:
    """Difference d(s) to the memorised value: level + rate·s + a·(1 − e^(−s/τ1)) + b·(…τ2)."""
    first, second = exp(-s_us / tau_us), exp(-s_us / follower_us)
    return level + rate * s_us + a * (1.0 - first) + b * (1.0 - second)


@compiled
def steepness(
    rate: float, a: float, b: float, tau_us: float, follower_us: float, s_us: float
) -> float:
    """Slope of d(s) [1/µs]."""
    first, second = exp(-s_us / tau_us), exp(-s_us / follower_us)
    return rate + a / tau_us * first + b / follower_us * second


@compiled
def turn_between(
    rate: float, a: float, b: float, tau_us: float, follower_us: float, low: float, high: float
) -> float:
    """Where d turns in a span on which its slope is monotone, or the span's end [µs]."""
    rising = steepness(rate, a, b, tau_us, follower_us, low) > 0.0
    if (steepness(rate, a, b, tau_us, follower_us, high) > 0.0) == rising:
        return high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if (steepness(rate, a, b, tau_us, follower_us, middle) > 0.0) == rising:
            low = middle
        else:
            high = middle
    return high


@compiled
def bend_us(a: float, b: float, tau_us: float, follower_us: float, span_us: float) -> float:
    """Where the slope of d turns, or `span_us` if it does not before [µs]."""
    ratio = -(b * tau_us * tau_us) / (a * follower_us * follower_us)
    if not ratio > 0.0:
        return span_us
    bend = log(ratio) / (1.0 / follower_us - 1.0 / tau_us)
    return bend if 0.0 < bend < span_us else span_us


@compiled
def crossing_between(
    level: float,
    rate: float,
    a: float,
    b: float,
    tau_us: float,
    follower_us: float,
    low: float,
    high: float,
    theta: float,
) -> float:
    """Where d, monotone from `low` to `high`, meets `theta` [µs]."""
    rising = course(level, rate, a, b, tau_us, follower_us, high) > theta
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if (course(level, rate, a, b, tau_us, follower_us, middle) > theta) == rising:
            high = middle
        else:
            low = middle
    return high


@compiled
def first_crossing_behind(
    level: float,
    rate: float,
    a: float,
    b: float,
    tau_us: float,
    follower_us: float,
    span_us: float,
    theta_on: float,
    theta_off: float,
) -> tuple[float, bool]:
    """First crossing of either threshold within (0, span_us], as `first_crossing` is for one pole.

    Args:
        level: d(0), between the thresholds.
        rate: steady slope of d [1/µs].
        a: amplitude of the exponential with τ1.
        b: amplitude of the exponential with τ2.
        tau_us: τ1 [µs].
        follower_us: τ2, unlike τ1 [µs].
        span_us: how far to look [µs].
        theta_on: ON threshold, positive.
        theta_off: OFF threshold, positive.

    Returns:
        Time [µs], `NEVER_US` if there is none, and whether it is ON.
    """
    bend = bend_us(a, b, tau_us, follower_us, span_us)
    first = turn_between(rate, a, b, tau_us, follower_us, 0.0, bend)
    second = turn_between(rate, a, b, tau_us, follower_us, bend, span_us)
    low = 0.0
    for high in (first, bend, second, span_us):
        end = course(level, rate, a, b, tau_us, follower_us, high)
        if end >= theta_on or end <= -theta_off:
            theta = theta_on if end >= theta_on else -theta_off
            at = crossing_between(level, rate, a, b, tau_us, follower_us, low, high, theta)
            return at, end >= theta_on
        low = high
    return NEVER_US, False
