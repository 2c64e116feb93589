"""Takes one pixel with noise through a piece of time, to its next event at most.

An event resets the pixel to what it sees, noise included. The noise that carried the pixel across
the threshold is afterwards part of its output, and decays as a lag of the photoreceptor does. With
a follower, the output moves on first, since the photoreceptor leads it. At the end of the
refractory period, the memory takes the noise of that moment. These two values are
the whole memory of the noise: settled pixels alternate between ON and OFF because of them.
"""

from __future__ import annotations

import math

import numpy as np

from emulator.noise.random_numbers import exponential, gaussian, uniform
from emulator.pixel.noisy.hazard import distances, hazards_of, lead_at_event
from emulator.pixel.noisy.passage import (
    LONGEST_US,
    SHORT,
    mean_difference,
    mean_slope,
    noisy_course,
    passage_us,
    piece_hazard,
    piece_us,
    quiet_us,
)
from emulator.pixel.segment import Mismatch, Pixel, Segment, lags_after, without_event
from emulator.pixel.single_pixel import NO_EVENT
from emulator.pixel.state import DRAWS, PixelModel
from flybench.events import Cause
from flybench.kernels import compiled, inlined
from flybench.portable_math import exp

_SIGNAL, _LEAK, _SHOT, _HOT = (
    int(cause) for cause in (Cause.SIGNAL, Cause.LEAK, Cause.SHOT, Cause.HOT)
)
_SETTLED = 0.1
"""Lag below which the response to the light is over, in units of σ (assumed)."""


@compiled
def leave_reset(
    pixel: Pixel, segment: Segment, model: PixelModel, index: int, span_us: float
) -> Pixel:
    """Return a pixel in reset after `span_us`; if the reset ends then, with the noise it memorises.

    Of the noise at the event, the share exp(−t/τ) is left, which the lag holds. The rest of the
    variance is drawn.
    """
    lag, second_lag = lags_after(pixel, segment, model, span_us, exp(-span_us * segment.corner))
    left_us = pixel.reset_us - span_us
    if left_us <= 0.0:
        noise = segment.noise
        kept = exp(-2.0 * model.refractory_us * noise.per_tau)
        drawn = gaussian(model.seed, index, pixel.draws - 1)
        lag -= noise.sigma * math.sqrt(1.0 - kept) * drawn
    return Pixel(lag, 0.0, 0.0, pixel.clock, max(left_us, 0.0), pixel.draws, second_lag)


@inlined
def mark_of(on: bool, change: float, leak: float, noise: float, moved: bool) -> int:
    """Return 2·cause + polarity of an event: its cause is what contributed most to it.

    Args:
        on: polarity.
        change: contribution of the signal, and of noise that an earlier event has memorised, to the
            difference [ln units].
        leak: contribution of the leak.
        noise: contribution of the noise.
        moved: False if the light has not changed for long, so that `change` is noise.
    """
    sign = 1.0 if on else -1.0
    signal, noise = sign * change, sign * noise
    if not moved:
        signal, noise = 0.0, noise + signal
    cause = _SIGNAL
    if noise > signal:
        cause = _SHOT
    if on and leak > max(noise, signal):
        cause = _LEAK
    return 2 * cause + on


@compiled
def fire(
    pixel: Pixel,
    segment: Segment,
    mismatch: Mismatch,
    model: PixelModel,
    index: int,
    event_us: float,
    moved: bool,
) -> tuple[Pixel, int]:
    """Return a pixel at its event `event_us` from now, held in reset; and 2·cause + polarity."""
    course = noisy_course(pixel, segment, model)
    d = mean_difference(course, event_us)
    h_on, h_off = distances(course.noise, mismatch, d)
    speed = mean_slope(course, event_us) / course.noise.sigma
    on_rate, off_rate = hazards_of(course.noise, h_on, h_off, speed)
    hot_rate = mismatch.hot_rate
    choice = uniform(model.seed, index, pixel.draws) * (on_rate + off_rate + abs(hot_rate))
    lag, second_lag = lags_after(pixel, segment, model, event_us, exp(-event_us * segment.corner))
    noise = lead = 0.0
    if choice < on_rate + off_rate:
        on = choice < on_rate
        noise = (mismatch.theta_on if on else -mismatch.theta_off) - d
        leak = pixel.leak + segment.leak_drift * event_us
        mark = mark_of(on, d - leak, leak, noise, moved)
        sign = 1.0 if on else -1.0
        lead = lead_at_event(course.noise, model.follower_us, sign * speed)
        lead *= sign * course.noise.sigma
    else:
        mark = 2 * _HOT + (choice - on_rate - off_rate >= -0.5 * hot_rate)
    clock = exponential(model.seed, index, pixel.draws + 1)
    draws = pixel.draws + np.int64(DRAWS)
    lag -= noise + lead
    return Pixel(lag, 0.0, 0.0, clock, model.refractory_us, draws, second_lag + lead), mark


@compiled
def advance_noisy(
    pixel: Pixel,
    segment: Segment,
    mismatch: Mismatch,
    model: PixelModel,
    index: int,
    left_us: float,
    still: bool,
    moved: bool,
) -> tuple[Pixel, float, int]:
    """Take a pixel through one piece of time: the rest of its reset, or to its next event at most.

    Args:
        pixel: pixel before.
        segment: present segment.
        mismatch: what differs from pixel to pixel.
        model: constants of the sensor.
        index: index of the pixel, for its random numbers.
        left_us: rest of the segment, which ends the piece unless the pixel is still [µs].
        still: True if the light is constant and may remain so beyond the segment. The piece then
            takes whole microseconds and as long as it would for any `left_us`.
        moved: True if a change of the light may contribute to the event.

    Returns:
        The pixel, the time until then [µs], and 2·cause + polarity of the event at that time, or
        `NO_EVENT`.
    """
    if pixel.reset_us > 0.0:
        wait_us = pixel.reset_us if still else min(pixel.reset_us, left_us)
        return leave_reset(pixel, segment, model, index, wait_us), wait_us, NO_EVENT
    silent_us = quiet_us(pixel, segment, mismatch, left_us)
    quiet = silent_us >= (SHORT / segment.noise.per_tau if still else left_us)
    course = noisy_course(pixel, segment, model)
    span_us = silent_us if quiet else piece_us(course, mismatch)
    span_us = float(math.ceil(min(span_us, LONGEST_US))) if still else min(span_us, left_us)
    clock = pixel.clock
    if not quiet:
        hazard = piece_hazard(course, mismatch, span_us)
        if hazard >= clock:
            event_us = passage_us(course, mismatch, clock, span_us)
            event_us = float(math.ceil(event_us)) if still else event_us
            pixel, mark = fire(pixel, segment, mismatch, model, index, event_us, moved)
            return pixel, event_us, mark
        clock -= hazard
    after = without_event(pixel, segment, model, span_us, exp(-span_us * segment.corner))
    after = Pixel(after.lag, after.change, after.leak, clock, 0.0, after.draws, after.second_lag)
    return after, span_us, NO_EVENT


@inlined
def has_settled(pixel: Pixel, segment: Segment) -> bool:
    """Return True if the output has come so near to its input that no change is left in it."""
    return abs(pixel.lag) + abs(pixel.second_lag) < _SETTLED * segment.noise.sigma


@inlined
def as_stored(pixel: Pixel) -> Pixel:
    """Return a pixel with the precision in which its state is stored."""
    return Pixel(
        np.float64(np.float32(pixel.lag)),
        np.float64(np.float32(pixel.change)),
        np.float64(np.float32(pixel.leak)),
        np.float64(np.float32(pixel.clock)),
        pixel.reset_us,
        pixel.draws,
        np.float64(np.float32(pixel.second_lag)),
    )
