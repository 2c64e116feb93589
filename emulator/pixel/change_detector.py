"""The change detector: when the difference to the memorised value first crosses a threshold.

Within a step the difference is known in closed form (see `emulator.pixel.photoreceptor`):

    d(s) = d(0) + rate·s + swing·(1 − exp(−s/τ))

with rate = slope of the input + drift of the memorised value by leak, swing = lag − slope·τ. It
has at most one turning point. On each side of it, d is monotone and crosses either threshold at
most once (Lichtsteiner, Posch, Delbruck 2008, section II: an ON event at d = θ_on, an OFF event at
d = −θ_off, then the pixel memorises the present value).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined
from flybench.portable_math import exp, log

THETA_MIN = 0.01
"""Smallest threshold after mismatch (also v2e's choice): a pixel with a threshold of zero or less
would fire without end, and would not leave the factory."""

NEVER_US = np.inf
"""Time of a crossing that does not happen."""

TIME_TOLERANCE_US = 1e-3
"""Precision of the time of a crossing [µs]; events are stamped to 1 µs."""

_SHORT_MOVE = 0.25
_ROUNDS_MAX = 60


class Course(NamedTuple):
    """The difference d(s) as a function of time.

    Attributes:
        start: d(0).
        rate: steady slope of d [1/µs].
        swing: amplitude of the exponential part of d.
        tau_us: time constant τ of the photoreceptor [µs].
    """

    start: float
    rate: float
    swing: float
    tau_us: float


def draw_thresholds(
    mean: float, mismatch: float, pixels: int, rng: np.random.Generator
) -> npt.NDArray[np.float32]:
    """Draw the thresholds of all pixels: Gaussian, at least `THETA_MIN`.

    Returns:
        (pixels,) float32 [ln units].
    """
    drawn = rng.normal(mean, mismatch, pixels)
    return np.maximum(drawn, THETA_MIN).astype(np.float32)


@compiled
def difference(course: Course, s_us: float) -> float:
    """Return the difference d(s) to the memorised value, `s_us` into the step."""
    return course.start + course.rate * s_us + course.swing * (1.0 - exp(-s_us / course.tau_us))


@compiled
def turning_point_us(course: Course, span_us: float) -> float:
    """Return the time at which d(s) turns, or `span_us` if it does not turn before."""
    share = -course.rate * course.tau_us / course.swing
    if not 0.0 < share < 1.0:
        return span_us
    return min(span_us, -course.tau_us * log(share))


@inlined
def is_close(move: float, curvature: float, slope: float, per_us: float) -> bool:
    """Return True if a Newton step has reached the tolerance.

    The error that it leaves is |d''/2d'|·move², if the step is so short that d'' hardly changes.

    Args:
        move: the step [µs].
        curvature: d'' before the step, up to its sign [1/µs²].
        slope: d' before the step [1/µs].
        per_us: 1/τ [1/µs].
    """
    near = abs(move) * per_us <= _SHORT_MOVE
    return near & (abs(curvature) * move * move <= TIME_TOLERANCE_US * abs(slope))


@compiled
def level_crossing_us(level: float, course: Course, low: float, high: float) -> float:
    """Return the time in [low, high], where d is monotone, at which d equals `level` [µs].

    Newton's method, started on the chord. A bisection replaces a step that leaves the bracket.
    """
    start, rate, swing, tau_us = course
    bottom = difference(course, low)
    top = difference(course, high)
    rising = top > bottom
    per_us = 1.0 / tau_us
    s = low + (high - low) * min(max((level - bottom) / (top - bottom), 0.0), 1.0)
    for _ in range(_ROUNDS_MAX):
        decay = exp(-s * per_us)
        excess = start + rate * s + swing * (1.0 - decay) - level
        if (excess > 0.0) == rising:
            high = s
        else:
            low = s
        bend = swing * decay * per_us
        slope = rate + bend
        move = excess / slope
        s -= move
        if not low <= s <= high:
            s = 0.5 * (low + high)
        elif is_close(move, bend * per_us, slope, per_us):
            break
    return s


@compiled
def stays_within(
    course: Course, span_us: float, decay: float, theta_on: float, theta_off: float
) -> bool:
    """Return True if d certainly stays between the thresholds for `span_us`: a quick test.

    It does if d ends between them and its slope has the same sign at both ends, so that d is
    monotone.

    Args:
        course: the difference; d(0) is between the thresholds.
        span_us: duration [µs].
        decay: exp(−span/τ), which the caller needs anyway.
        theta_on: ON threshold, positive.
        theta_off: OFF threshold, positive.
    """
    start, rate, swing, tau_us = course
    end = start + rate * span_us + swing * (1.0 - decay)
    monotone = (rate * tau_us + swing) * (rate * tau_us + swing * decay) >= 0.0
    return monotone and -theta_off < end < theta_on


@compiled
def first_crossing(
    course: Course, span_us: float, theta_on: float, theta_off: float
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
    low = 0.0
    high = turning_point_us(course, span_us)
    for _ in range(2):
        end = difference(course, high)
        if end >= theta_on:
            return level_crossing_us(theta_on, course, low, high), True
        if end <= -theta_off:
            return level_crossing_us(-theta_off, course, low, high), False
        low = high
        high = span_us
    return NEVER_US, False
