"""Follows one event pixel to its next event.

Threshold crossings and noise compete; whichever comes first resets the pixel. While the pixel is
refractory, the memorised value follows the photoreceptor, so that changes in that time are lost
(Lichtsteiner, Posch, Delbruck 2008). A noise event resets the pixel like any other event.
"""

from __future__ import annotations

from emulator.noise.random_numbers import exponential, uniform
from emulator.pixel.change_detector import NEVER_US, Course, first_crossing, stays_within
from emulator.pixel.segment import Mismatch, Pixel, Segment, hold_in_reset, without_event
from emulator.pixel.source_follower import (
    SecondOrderCourse,
    amplitudes,
    first_second_order_crossing,
    separated,
)
from emulator.pixel.state import PixelModel
from flybench.events import Cause
from flybench.kernels import compiled, inlined
from flybench.portable_math import exp

NO_EVENT = -1

_SIGNAL_OFF = 2 * int(Cause.SIGNAL)
_SIGNAL_ON = 2 * int(Cause.SIGNAL) + 1
_LEAK_ON = 2 * int(Cause.LEAK) + 1
_SHOT_OFF = 2 * int(Cause.SHOT)
_SHOT_ON = 2 * int(Cause.SHOT) + 1
_HOT_OFF = 2 * int(Cause.HOT)
_HOT_ON = 2 * int(Cause.HOT) + 1

_WAKE_MARGIN = 1e-5
"""Distance from a threshold beyond which a pixel may sleep [ln units]: well above the rounding of
its state."""

LONGEST_SLEEP_US = 2.0**30
"""Longest time that a pixel may sleep: its times are kept modulo 2^32 µs."""


@inlined
def crossing_code(leak: float, theta_on: float, on: bool) -> int:
    """Return 2·cause + polarity of a crossing.

    The cause is the leak if it has drifted further than the signal has changed.

    Args:
        leak: drift of the leak [ln units].
        theta_on: ON threshold, which leak and signal have reached together [ln units].
        on: True if the ON threshold was crossed.
    """
    if not on:
        return _SIGNAL_OFF
    return _LEAK_ON if leak > theta_on - leak else _SIGNAL_ON


@compiled
def hot_event(
    pixel: Pixel, segment: Segment, hot_rate: float, model: PixelModel, index: int
) -> tuple[Pixel, int]:
    """Return the pixel with its clock started again, and 2·cause + polarity of the event.

    A hot pixel fires ON (assumed: its current discharges the node as leak does). A crazy pixel,
    whose rate is stored as a negative number, fires ON and OFF equally often (assumed).
    """
    choice = uniform(model.seed, index, pixel.draws) * segment.hot_rate
    clock = exponential(model.seed, index, pixel.draws + 1)
    pixel = Pixel(
        pixel.lag,
        pixel.change,
        pixel.leak,
        clock,
        pixel.reset_us,
        pixel.draws + 2,
        pixel.second_lag,
    )
    return pixel, _HOT_OFF if choice < -0.5 * hot_rate else _HOT_ON


@inlined
def reset_at(
    pixel: Pixel, segment: Segment, model: PixelModel, at_us: float, left_us: float
) -> tuple[Pixel, float]:
    """Take a pixel through an event and its reset, or to the end of the segment.

    Args:
        pixel: pixel before.
        segment: present segment.
        model: constants of the sensor.
        at_us: time until the event [µs].
        left_us: rest of the segment [µs].

    Returns:
        The pixel, and the time until then [µs].
    """
    hold_us = min(model.refractory_us, left_us - at_us)
    waiting = Pixel(
        pixel.lag, 0.0, 0.0, pixel.clock, model.refractory_us, pixel.draws, pixel.second_lag
    )
    return hold_in_reset(waiting, segment, model, at_us, hold_us), at_us + hold_us


@inlined
def next_crossing(
    pixel: Pixel,
    segment: Segment,
    mismatch: Mismatch,
    model: PixelModel,
    span_us: float,
    decay: float,
) -> tuple[float, bool]:
    """Return the first crossing of a threshold within `span_us`, and True if it is ON.

    Args:
        pixel: pixel before.
        segment: present segment.
        mismatch: thresholds of the pixel.
        model: constants of the sensor.
        span_us: end of the search [µs].
        decay: exp(−span/τ).

    Returns:
        As `first_crossing`.
    """
    start = pixel.change + pixel.leak
    rate = segment.slope + segment.leak_drift
    tau_us, theta_on, theta_off = segment.tau_us, mismatch.theta_on, mismatch.theta_off
    if model.follower_us > 0.0:
        follower_us = separated(tau_us, model.follower_us)
        a, b = amplitudes(pixel.lag, pixel.second_lag, segment.slope, tau_us, follower_us)
        second_order = SecondOrderCourse(start, rate, a, b, tau_us, follower_us)
        return first_second_order_crossing(second_order, span_us, theta_on, theta_off)
    course = Course(start, rate, pixel.lag - segment.slope * tau_us, tau_us)
    if stays_within(course, span_us, decay, theta_on, theta_off):
        return NEVER_US, False
    return first_crossing(course, span_us, theta_on, theta_off)


@inlined
def advance(
    pixel: Pixel,
    segment: Segment,
    mismatch: Mismatch,
    model: PixelModel,
    index: int,
    left_us: float,
) -> tuple[Pixel, float, float, int]:
    """Take a pixel through its next event and the reset after it, or to the end of the segment.

    Args:
        pixel: pixel before.
        segment: present segment.
        mismatch: thresholds and hot rate of the pixel.
        model: constants of the sensor.
        index: index of the pixel, for its random numbers.
        left_us: rest of the segment [µs].

    Returns:
        The pixel, the time until then [µs], the time until the event [µs], and 2·cause + polarity
        or `NO_EVENT`.
    """
    if pixel.reset_us > 0.0:
        wait_us = min(pixel.reset_us, left_us)
        return hold_in_reset(pixel, segment, model, 0.0, wait_us), wait_us, 0.0, NO_EVENT
    noisy = pixel.clock <= segment.hot_rate * left_us
    span_us = max(0.0, pixel.clock / segment.hot_rate) if noisy else left_us
    decay = exp(-span_us * segment.corner)
    crossing_us, on = next_crossing(pixel, segment, mismatch, model, span_us, decay)
    if crossing_us < NEVER_US:
        leak = pixel.leak + segment.leak_drift * crossing_us
        pixel, spent_us = reset_at(pixel, segment, model, crossing_us, left_us)
        return pixel, spent_us, crossing_us, crossing_code(leak, mismatch.theta_on, on)
    if not noisy:
        return without_event(pixel, segment, model, span_us, decay), span_us, 0.0, NO_EVENT
    pixel, spent_us = reset_at(pixel, segment, model, span_us, left_us)
    pixel, mark = hot_event(pixel, segment, mismatch.hot_rate, model, index)
    return pixel, spent_us, span_us, mark


@inlined
def silent_time_us(pixel: Pixel, mismatch: Mismatch, drift: float) -> float:
    """Return how long a pixel under constant luminance certainly stays silent [µs].

    Args:
        pixel: state of the pixel.
        mismatch: thresholds of the pixel.
        drift: drift of the memorised value by leak [ln units/µs].
    """
    level = pixel.change + pixel.leak
    total = pixel.lag + pixel.second_lag
    highest = level + max(total, pixel.second_lag, 0.0) + _WAKE_MARGIN
    lowest = level + min(total, pixel.second_lag, 0.0) - _WAKE_MARGIN
    if pixel.reset_us > 0.0 or highest >= mismatch.theta_on or lowest <= -mismatch.theta_off:
        return 0.0
    silent_us = min(pixel.clock / abs(mismatch.hot_rate), (mismatch.theta_on - highest) / drift)
    return max(0.0, min(silent_us, LONGEST_SLEEP_US))
