"""When noise carries one pixel across a threshold.

Between events only the mean d(s) of the difference to the memorised value is followed; it is known
in closed form. The noise around it is not: it is stationary, and the pixel has a clock that starts
at a unit exponential random number and loses the hazard (`emulator.pixel.noisy.hazard`). When it
reaches 0, there is an event.
"""

from __future__ import annotations

from typing import NamedTuple

from emulator.noise.first_passage import H_MAX, surprise
from emulator.noise.photoreceptor_noise import Noise
from emulator.pixel.noisy.hazard import approach_hazard, distances, hazards_of, steady_rate
from emulator.pixel.segment import Mismatch, Pixel, Segment
from emulator.pixel.source_follower import amplitudes, separated
from emulator.pixel.state import PixelModel
from flybench.kernels import inlined
from flybench.portable_math import exp

LONGEST_US = 2.0**29
"""Longest piece: the times of a pixel are kept modulo 2^32 µs."""

_LARGEST_MOVE = 0.7
"""Distance that d may move in a piece, in units of σ, if the piece is not short."""

SHORT = 0.1
"""Length of a piece, in units of the correlation time, in which d may move farther: the noise
hardly changes meanwhile."""

_ROUNDS_MAX = 40
_TIME_TOLERANCE_US = 0.05
_RELATIVE_TOLERANCE = 1e-5


class NoisyCourse(NamedTuple):
    """The mean difference d(s), and the noise around it.

    d(s) = start + rate·s + a·(1 − exp(−s/τ1)) + b·(1 − exp(−s/τ2)).

    Attributes:
        start: d(0).
        rate: steady slope of d [1/µs].
        a: amplitude of the exponential of the photoreceptor.
        b: amplitude of the exponential of the follower.
        corner: 1/τ1 [1/µs].
        second_corner: 1/τ2, 0 without a follower [1/µs].
        noise: noise of the photoreceptor.
    """

    start: float
    rate: float
    a: float
    b: float
    corner: float
    second_corner: float
    noise: Noise


@inlined
def noisy_course(pixel: Pixel, segment: Segment, model: PixelModel) -> NoisyCourse:
    """Return the course of a pixel that is not in reset."""
    start, rate = pixel.change + pixel.leak, segment.slope + segment.leak_drift
    tau_us = segment.tau_us
    a, b, second_corner = pixel.lag - segment.slope * tau_us, 0.0, 0.0
    if model.follower_us > 0.0:
        follower_us = separated(tau_us, model.follower_us)
        a, b = amplitudes(pixel.lag, pixel.second_lag, segment.slope, tau_us, follower_us)
        second_corner = 1.0 / follower_us
    return NoisyCourse(start, rate, a, b, segment.corner, second_corner, segment.noise)


@inlined
def mean_difference(course: NoisyCourse, s_us: float) -> float:
    """Return d(s)."""
    first, second = exp(-s_us * course.corner), exp(-s_us * course.second_corner)
    return course.start + course.rate * s_us + course.a * (1.0 - first) + course.b * (1.0 - second)


@inlined
def mean_slope(course: NoisyCourse, s_us: float) -> float:
    """Return the slope of d(s) [1/µs]."""
    first, second = exp(-s_us * course.corner), exp(-s_us * course.second_corner)
    return course.rate + course.a * course.corner * first + course.b * course.second_corner * second


@inlined
def bounds(level: float, second_lag: float, total: float, end: float) -> tuple[float, float]:
    """Return the least and the greatest value that d can take, without leak and noise.

    The output stays between its present value, that of the photoreceptor and the input, which moves
    to the end of a ramp.

    Args:
        level: d now.
        second_lag: photoreceptor's output minus the follower's.
        total: input minus the follower's output, now.
        end: input at the end of the ramp, minus the follower's output now.
    """
    low = min(min(second_lag, total), min(end, 0.0))
    high = max(max(second_lag, total), max(end, 0.0))
    return level + low, level + high


@inlined
def quiet_us(pixel: Pixel, segment: Segment, mismatch: Mismatch, span_us: float) -> float:
    """Return how long noise certainly stays away from the thresholds, within `span_us` [µs].

    The leak is counted on top of `bounds`. Beyond 7 σ there is no noise.
    """
    total = pixel.lag + pixel.second_lag
    end = total + segment.slope * span_us
    low, high = bounds(pixel.change + pixel.leak, pixel.second_lag, total, end)
    margin = H_MAX * segment.noise.sigma
    low, high = low - margin, high + margin
    if mismatch.hot_rate != 0.0 or low <= -mismatch.theta_off or high >= mismatch.theta_on:
        return 0.0
    return (mismatch.theta_on - high) / segment.leak_drift


@inlined
def piece_us(course: NoisyCourse, mismatch: Mismatch) -> float:
    """Return the length of the next piece of time, over which the hazard is integrated [µs].

    The piece ends before noise comes within 7 σ, or is so short that d moves by less than σ or the
    noise hardly changes.
    """
    noise = course.noise
    speed = abs(course.rate) + abs(course.a) * course.corner + abs(course.b) * course.second_corner
    h_on, h_off = distances(noise, mismatch, course.start)
    move = max(_LARGEST_MOVE, min(h_on, h_off) - H_MAX)
    return min(max(move * noise.sigma / speed, SHORT / noise.per_tau), LONGEST_US)


@inlined
def piece_hazard(course: NoisyCourse, mismatch: Mismatch, span_us: float) -> float:
    """Return the hazard of a piece, in which d is taken to move steadily."""
    end = mean_difference(course, span_us)
    steady = steady_rate(course.noise, mismatch, course.start, end, span_us) * span_us
    return steady + approach_hazard(course.noise, mismatch, course.start, end)


@inlined
def passage_us(course: NoisyCourse, mismatch: Mismatch, clock: float, span_us: float) -> float:
    """Return the time at which the hazard of a piece has used up the clock [µs].

    Newton's method, from the end of the piece: the hazard grows ever faster, so that the steps
    approach the time from above. A bisection replaces a step that leaves the bracket. The hazard of
    noise may grow tenfold in a piece: if it were spread evenly, the events would come too early,
    with more noise to decay and so more events after them.

    Args:
        course: mean difference and noise.
        mismatch: thresholds of the pixel.
        clock: rest of the clock, which the hazard of the whole piece exceeds.
        span_us: length of the piece [µs].
    """
    noise = course.noise
    tolerance_us = max(_TIME_TOLERANCE_US, _RELATIVE_TOLERANCE * span_us)
    sign = 1.0 if mean_difference(course, span_us) > course.start else -1.0
    on_before, off_before = distances(noise, mismatch, course.start)
    used = surprise(on_before if sign > 0.0 else off_before) + clock
    low, high, s = 0.0, span_us, span_us
    for _ in range(_ROUNDS_MAX):
        d = mean_difference(course, s)
        h_on, h_off = distances(noise, mismatch, d)
        h = h_on if sign > 0.0 else h_off
        excess = steady_rate(noise, mismatch, course.start, d, s) * s + surprise(h) - used
        if excess > 0.0:
            high = s
        else:
            low = s
        speed = mean_slope(course, s) / noise.sigma
        on_rate, off_rate = hazards_of(noise, h_on, h_off, speed)
        move = excess / (on_rate + off_rate + abs(mismatch.hot_rate))
        s -= move
        if not low <= s <= high:
            s = 0.5 * (low + high)
        elif abs(move) < tolerance_us:
            break
    return s
