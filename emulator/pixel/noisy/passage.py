"""When noise carries one pixel across a threshold.

Between events only the mean d(s) of the difference to the memorised value is followed; it is known
in closed form. The noise around it is not: it is stationary, with a standard deviation σ, and the
pixel has a clock that starts at a unit exponential random number and loses the hazard

    Λ' = A_on + A_off + B_on + B_off,  A = c·ν(h)/((1 + s·h)·τ),  B = max(0, −h')·φ(h)/Φ(h)
    h_on = (θ_on − d)/σ,  h_off = (θ_off + d)/σ

(`emulator.noise.first_passage`; the factor with s is for two low-passes in a row, see
`emulator.noise.photoreceptor_noise`; c ≤ 1 is `moving_share`). When it reaches 0, there is an
event. Over a piece of time in
which d is monotone, the integral of B is a difference of −ln Φ(h). As σ falls, B makes the crossing
as sharp as that of a pixel without noise.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from emulator.noise.first_passage import H_MAX, decay_rate, sojourn, surprise, surprise_slope
from emulator.noise.photoreceptor_noise import SMOOTHING, Noise
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

_NEARER_PART = 0.35
"""Distance in σ over which ν falls to less than half, at usual distances of 2 to 5 σ."""

_WIDTH = 5e-4
"""Distance in σ by which every move is widened, so that no difference is divided by zero."""

_RICE = math.sqrt(0.5 * math.pi)
"""Mean slope of Gaussian noise as it crosses a fixed threshold, over its standard deviation."""

_SHORTEST = 1e-9
"""Shortest duration of a move, in correlation times, so that its speed is finite."""

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
def distances(noise: Noise, mismatch: Mismatch, d: float) -> tuple[float, float]:
    """Return the distances h of d from the ON and the OFF threshold, in units of σ."""
    return (mismatch.theta_on - d) / noise.sigma, (mismatch.theta_off + d) / noise.sigma


@inlined
def moving_share(noise: Noise, h: float, speed: float) -> float:
    """Return the share c of the diffusion rate that is left at a threshold that moves.

    ν presumes that the noise near the threshold has crossed it long ago. If the threshold comes
    fast, that noise is still there, and B alone lets it cross. A process that approaches h at the
    speed v, in σ per correlation time, then has the density of crossings φ(h)·(v + h) (Durbin, J.
    Appl. Prob. 22, 1985, first approximation). Hence ν becomes m·(m + h), with m = φ/Φ; its ratio
    to ν is 1/(1 + 0.45y + 0.17y²), with y = max(1 − h, 0), within 9 % for −3 < h < 1. The weight
    of the fast form is v/(1 + v) (assumed). From a threshold that goes, the noise falls behind:
    1/(1 + |v|/2) is within a third of the Fokker-Planck equation for |v| up to 10 and h up to 3.

    Two low-passes make the noise smooth, with a slope of the standard deviation 1/√(τ1·τ2).
    Crossings of a smooth process have the density φ(h)·E[max(v + slope, 0)] (Rice 1944), of which B
    holds φ(h)·max(v, 0). The polynomial of x = |v|·√(τ1·τ2) approaches what is left.
    """
    v = abs(speed)
    x = v * noise.smoothing * (1.0 / SMOOTHING)
    y = max(1.0 - h, 0.0)
    near = 1.0 + y * (0.45 + y * 0.17)
    smooth = 1.0 + x * (1.25 + x * (1.07 + x * 1.4))
    left = near + v if speed > 0.0 else 1.0
    whole = near * (1.0 + v) if speed > 0.0 else 1.0 + 0.5 * v
    return left / (whole * smooth)


@inlined
def diffusion_rate(noise: Noise, h: float, speed: float) -> float:
    """Return the hazard A of noise at a threshold [1/µs].

    Args:
        noise: noise of the photoreceptor.
        h: distance of the threshold [σ].
        speed: −h', by which it approaches [σ per correlation time].
    """
    rate = decay_rate(h) * noise.per_tau / (1.0 + noise.smoothing * max(h, 0.0))
    return rate * moving_share(noise, h, speed)


@inlined
def mean_diffusion_rate(noise: Noise, before: float, after: float, spans: float) -> float:
    """Return the mean of `diffusion_rate` while h moves steadily from `before` to `after` [1/µs].

    The factors of ν are those of a place in the nearer part, where most crossings are.

    Args:
        noise: noise of the photoreceptor.
        before: distance of the threshold at the start [σ].
        after: distance at the end [σ].
        spans: correlation time over the duration of the move (`spans_per_tau`).
    """
    near, far = min(before, after) - _WIDTH, max(before, after) + _WIDTH
    weighted = near + min(0.5 * (far - near), _NEARER_PART)
    width = (far - near) * (1.0 + noise.smoothing * max(weighted, 0.0))
    share = moving_share(noise, weighted, (before - after) * spans)
    return (sojourn(near) - sojourn(far)) / width * noise.per_tau * share


@inlined
def spans_per_tau(noise: Noise, span_us: float) -> float:
    """Return the correlation time of the noise over a duration, which may be 0."""
    return 1.0 / max(span_us * noise.per_tau, _SHORTEST)


@inlined
def approach_hazard(noise: Noise, mismatch: Mismatch, before: float, after: float) -> float:
    """Return the hazard that d adds as it moves, monotone, from `before` to `after`."""
    on_before, off_before = distances(noise, mismatch, before)
    on_after, off_after = distances(noise, mismatch, after)
    on = max(surprise(on_after) - surprise(on_before), 0.0)
    off = max(surprise(off_after) - surprise(off_before), 0.0)
    return on + off


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
def steady_rate(
    noise: Noise, mismatch: Mismatch, before: float, after: float, span_us: float
) -> float:
    """Return the mean hazard of noise and of a hot pixel as d moves from `before` to `after`."""
    on_before, off_before = distances(noise, mismatch, before)
    on_after, off_after = distances(noise, mismatch, after)
    spans = spans_per_tau(noise, span_us)
    rate = mean_diffusion_rate(noise, on_before, on_after, spans)
    rate += mean_diffusion_rate(noise, off_before, off_after, spans)
    return rate + abs(mismatch.hot_rate)


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


@inlined
def hazards_of(noise: Noise, h_on: float, h_off: float, speed: float) -> tuple[float, float]:
    """Return the hazards of the ON and of the OFF threshold, hot pixels aside [1/µs].

    Args:
        noise: noise of the photoreceptor.
        h_on: distance of d from the ON threshold, in units of σ.
        h_off: distance of d from the OFF threshold, in units of σ.
        speed: slope of d in σ [1/µs].
    """
    per_tau = speed / noise.per_tau
    on = diffusion_rate(noise, h_on, per_tau) + max(speed, 0.0) * surprise_slope(h_on)
    off = diffusion_rate(noise, h_off, -per_tau) + max(-speed, 0.0) * surprise_slope(h_off)
    return on, off


@inlined
def lead_at_event(noise: Noise, follower_us: float, speed: float) -> float:
    """Return by how much the photoreceptor's noise leads the follower's at an event [σ].

    The output of the follower moves on by (v − w)/τ2. Noise that crosses a threshold has, on
    average, the slope E[n'·max(v + n', 0)]/E[max(v + n', 0)] (Rice 1944), with n' as in
    `moving_share`. That is 1.25/(1 + 0.45x + 0.17x²) standard deviations of n', within 3 % for
    x < 3.

    Args:
        noise: noise of the photoreceptor.
        follower_us: time constant τ2 of the follower, 0 without one [µs].
        speed: speed v at which the threshold approaches, in σ [1/µs].
    """
    root_us = noise.smoothing * (1.0 / SMOOTHING) / noise.per_tau
    x = max(speed, 0.0) * root_us
    slope = _RICE / (1.0 + x * (0.45 + x * 0.17))
    return slope * follower_us / max(root_us, 1e-3)
