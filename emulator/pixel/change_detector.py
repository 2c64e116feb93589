"""The change detector: when the difference to the memorised value first crosses a threshold.

Within a step the difference is known in closed form (see `emulator.pixel.photoreceptor`):

    d(s) = d(0) + rate·s + swing·(1 − exp(−s/τ))

with rate = slope of the input + drift of the memorised value by leak, swing = lag − slope·τ. It
has at most one turning point, so each side of it is monotone and holds at most one crossing of
either threshold (Lichtsteiner, Posch, Delbruck 2008, section II: an ON event at d = θ_on, an OFF
event at d = −θ_off, then the pixel memorises the present value).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined
from flybench.portable_math import exp, log

THETA_MIN = 0.01
"""Least threshold that mismatch may leave a pixel (v2e's choice too): a pixel at or below zero
would fire without end, and is not one that leaves the factory."""

NEVER_US = np.inf
"""Time of a crossing that does not happen."""

TIME_TOLERANCE_US = 1e-3
"""How exactly a crossing is found [µs]; events are stamped to 1 µs."""

_SHORT_MOVE = 0.25
_ROUNDS_MAX = 60


def draw_thresholds(
    mean: float, mismatch: float, pixels: int, rng: np.random.Generator
) -> npt.NDArray[np.float32]:
    """Frozen thresholds of all pixels: Gaussian, at least `THETA_MIN`.

    Returns:
        (pixels,) float32 [ln units].
    """
    drawn = rng.normal(mean, mismatch, pixels)
    return np.maximum(drawn, THETA_MIN).astype(np.float32)


@compiled
def difference(start: float, rate: float, swing: float, tau_us: float, s_us: float) -> float:
    """Difference d(s) to the memorised value, `s_us` into the step."""
    return start + rate * s_us + swing * (1.0 - exp(-s_us / tau_us))


@compiled
def turning_point_us(rate: float, swing: float, tau_us: float, span_us: float) -> float:
    """Time at which d(s) turns, or `span_us` where it doesn't before."""
    share = -rate * tau_us / swing
    if not 0.0 < share < 1.0:
        return span_us
    return min(span_us, -tau_us * log(share))


@inlined
def is_close(move: float, curvature: float, slope: float, per_us: float) -> bool:
    """Whether a step of Newton's has come within the tolerance.

    It leaves an error of |d''/2d'|·move², if the move is so short that d'' hardly changes.

    Args:
        move: the step [µs].
        curvature: d'' before it, up to its sign [1/µs²].
        slope: d' before it [1/µs].
        per_us: 1/τ [1/µs].
    """
    near = abs(move) * per_us <= _SHORT_MOVE
    return near & (abs(curvature) * move * move <= TIME_TOLERANCE_US * abs(slope))


@compiled
def level_crossing_us(
    level: float, start: float, rate: float, swing: float, tau_us: float, low: float, high: float
) -> float:
    """Time in [low, high], where d is monotone, at which it meets `level` [µs].

    Newton's steps from the chord, kept inside a bracket that halves when they leave it.
    """
    bottom = difference(start, rate, swing, tau_us, low)
    top = difference(start, rate, swing, tau_us, high)
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
    start: float,
    rate: float,
    swing: float,
    tau_us: float,
    span_us: float,
    decay: float,
    theta_on: float,
    theta_off: float,
) -> bool:
    """Whether d surely stays between the thresholds for `span_us`: the quick answer.

    It does if d ends between them and, its slope having the same sign at both ends, is monotone.

    Args:
        start: d(0), between the thresholds.
        rate: steady slope of d [1/µs].
        swing: amplitude of the exponential part of d.
        tau_us: time constant of the photoreceptor [µs].
        span_us: how far to look [µs].
        decay: exp(−span/τ), which the caller needs anyway.
        theta_on: ON threshold, positive.
        theta_off: OFF threshold, positive.
    """
    end = start + rate * span_us + swing * (1.0 - decay)
    monotone = (rate * tau_us + swing) * (rate * tau_us + swing * decay) >= 0.0
    return monotone and -theta_off < end < theta_on


@compiled
def first_crossing(
    start: float,
    rate: float,
    swing: float,
    tau_us: float,
    span_us: float,
    theta_on: float,
    theta_off: float,
) -> tuple[float, bool]:
    """First crossing of either threshold within (0, span_us].

    Args:
        start: d(0), between the thresholds.
        rate: steady slope of d [1/µs].
        swing: amplitude of the exponential part of d.
        tau_us: time constant of the photoreceptor [µs].
        span_us: how far to look [µs].
        theta_on: ON threshold, positive.
        theta_off: OFF threshold, positive.

    Returns:
        Time [µs], `NEVER_US` if there is none, and whether it is ON.
    """
    low = 0.0
    high = turning_point_us(rate, swing, tau_us, span_us)
    for _ in range(2):
        end = difference(start, rate, swing, tau_us, high)
        if end >= theta_on:
            return level_crossing_us(theta_on, start, rate, swing, tau_us, low, high), True
        if end <= -theta_off:
            return level_crossing_us(-theta_off, start, rate, swing, tau_us, low, high), False
        low = high
        high = span_us
    return NEVER_US, False
