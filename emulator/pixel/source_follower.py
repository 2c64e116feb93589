"""The source follower behind the photoreceptor: an option that makes the pixel second order.

The follower's output w follows the photoreceptor's output v through τ2·dw/dt = v − w; its bias sets
τ2, which does not depend on the light (Lichtsteiner, Posch, Delbruck 2008; Graça, Delbruck 2021).
With the lag l = u − v, the photoreceptor's τ1, and the slope r of u, the second lag m = v − w is,
exactly,

    m(s) = r·τ2 + K·exp(−s/τ1) + (m(0) − r·τ2 − K)·exp(−s/τ2),  K = (l(0) − r·τ1)·τ2/(τ1 − τ2)

so the difference to the memorised value is a line and two exponentials, and turns at most twice.
"""

from __future__ import annotations

from typing import NamedTuple

from emulator.pixel.change_detector import NEVER_US
from flybench.kernels import compiled
from flybench.portable_math import exp, log

_MIN_RELATIVE_DIFFERENCE = 1e-3
"""Smallest relative difference between τ1 and τ2; a smaller one is set to it. The closed form has a
removable singularity where the two are equal."""

_HALVINGS = 50


class SecondOrderCourse(NamedTuple):
    """The difference d(s) to the memorised value as a function of time.

    d(s) = start + rate·s + a·(1 − exp(−s/τ1)) + b·(1 − exp(−s/τ2)).

    Attributes:
        start: d(0).
        rate: steady slope of d [1/µs].
        a: amplitude of the exponential with τ1.
        b: amplitude of the exponential with τ2.
        tau_us: time constant τ1 of the photoreceptor [µs].
        follower_us: time constant τ2 of the follower, different from τ1 [µs].
    """

    start: float
    rate: float
    a: float
    b: float
    tau_us: float
    follower_us: float


@compiled
def separated(tau_us: float, follower_us: float) -> float:
    """Return τ2, moved away from τ1 if the two are almost equal."""
    if abs(follower_us - tau_us) < _MIN_RELATIVE_DIFFERENCE * tau_us:
        return tau_us * (1.0 + _MIN_RELATIVE_DIFFERENCE)
    return follower_us


@compiled
def separated_corner(corner: float, follower_us: float) -> float:
    """Return 1/τ2 of `separated`, without a division for each pixel; `corner` is 1/τ1."""
    if abs(follower_us * corner - 1.0) < _MIN_RELATIVE_DIFFERENCE:
        return corner * (1.0 / (1.0 + _MIN_RELATIVE_DIFFERENCE))
    return 1.0 / follower_us


@compiled
def amplitudes(
    lag: float, second_lag: float, slope: float, tau_us: float, follower_us: float
) -> tuple[float, float]:
    """Return the amplitudes of the two exponentials in the course of w, for τ1 and for τ2.

    Args:
        lag: u − v at the start.
        second_lag: v − w at the start.
        slope: slope of u [1/µs].
        tau_us: τ1 [µs].
        follower_us: τ2, different from τ1 [µs].
    """
    first = lag - slope * tau_us
    coupling = first * follower_us / (tau_us - follower_us)
    return first + coupling, second_lag - slope * follower_us - coupling


@compiled
def second_lag_after(
    lag: float, second_lag: float, slope: float, tau_us: float, follower_us: float, span_us: float
) -> float:
    """Return the second lag v − w after a ramp of `slope` per µs for `span_us`."""
    follower_us = separated(tau_us, follower_us)
    first = lag - slope * tau_us
    coupling = first * follower_us / (tau_us - follower_us)
    own = second_lag - slope * follower_us - coupling
    decay, decay_2 = exp(-span_us / tau_us), exp(-span_us / follower_us)
    return slope * follower_us + coupling * decay + own * decay_2


@compiled
def value_at(course: SecondOrderCourse, s_us: float) -> float:
    """Return the difference d(s)."""
    first, second = exp(-s_us / course.tau_us), exp(-s_us / course.follower_us)
    return course.start + course.rate * s_us + course.a * (1.0 - first) + course.b * (1.0 - second)


@compiled
def slope_at(course: SecondOrderCourse, s_us: float) -> float:
    """Return the slope of d(s) [1/µs]."""
    first, second = exp(-s_us / course.tau_us), exp(-s_us / course.follower_us)
    return course.rate + course.a / course.tau_us * first + course.b / course.follower_us * second


@compiled
def turning_point_between(course: SecondOrderCourse, low: float, high: float) -> float:
    """Return the time at which d turns in a span on which its slope is monotone, or `high` [µs]."""
    rising = slope_at(course, low) > 0.0
    if (slope_at(course, high) > 0.0) == rising:
        return high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if (slope_at(course, middle) > 0.0) == rising:
            low = middle
        else:
            high = middle
    return high


@compiled
def inflection_us(course: SecondOrderCourse, span_us: float) -> float:
    """Return the time at which the slope of d turns, or `span_us` if it does not before [µs]."""
    _, _, a, b, tau_us, follower_us = course
    ratio = -(b * tau_us * tau_us) / (a * follower_us * follower_us)
    if not ratio > 0.0:
        return span_us
    inflection = log(ratio) / (1.0 / follower_us - 1.0 / tau_us)
    return inflection if 0.0 < inflection < span_us else span_us


@compiled
def crossing_between(course: SecondOrderCourse, low: float, high: float, theta: float) -> float:
    """Return the time at which d, monotone from `low` to `high`, equals `theta` [µs]."""
    rising = value_at(course, high) > theta
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if (value_at(course, middle) > theta) == rising:
            high = middle
        else:
            low = middle
    return high


@compiled
def first_second_order_crossing(
    course: SecondOrderCourse, span_us: float, theta_on: float, theta_off: float
) -> tuple[float, bool]:
    """Return the first crossing of either threshold within (0, span_us].

    Args:
        course: the difference; d(0) is between the thresholds.
        span_us: end of the search [µs].
        theta_on: ON threshold, positive.
        theta_off: OFF threshold, positive.

    Returns:
        Time [µs], `NEVER_US` if there is none; and True if it is the ON threshold.
    """
    inflection = inflection_us(course, span_us)
    first = turning_point_between(course, 0.0, inflection)
    second = turning_point_between(course, inflection, span_us)
    low = 0.0
    for high in (first, inflection, second, span_us):
        end = value_at(course, high)
        if end >= theta_on or end <= -theta_off:
            theta = theta_on if end >= theta_on else -theta_off
            return crossing_between(course, low, high, theta), end >= theta_on
        low = high
    return NEVER_US, False
