"""One event pixel on its way to its next event.

Threshold crossings and noise compete; the first one resets the pixel. While the pixel is
refractory the memorised value follows the photoreceptor, so what changes meanwhile is lost
(Lichtsteiner, Posch, Delbruck 2008). A noise event resets the pixel as any other does.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from emulator._compile import compiled, inlined
from emulator.change_detector import NEVER_US, first_crossing, stays_within
from emulator.events import Cause
from emulator.noise import exponential, leak_drift, shot_rates, uniform
from emulator.photoreceptor import corner_per_us, lag_after
from emulator.pixels import PixelModel

NO_EVENT = -1

_SIGNAL_OFF = 2 * int(Cause.SIGNAL)
_SIGNAL_ON = 2 * int(Cause.SIGNAL) + 1
_LEAK_ON = 2 * int(Cause.LEAK) + 1
_SHOT_OFF = 2 * int(Cause.SHOT)
_SHOT_ON = 2 * int(Cause.SHOT) + 1
_HOT_ON = 2 * int(Cause.HOT) + 1

_WAKE_MARGIN = 1e-5
"""How far from a threshold a pixel may sleep [ln units]: well above the rounding of its state."""

_FAR_US = 1e15


class Pixel(NamedTuple):
    """What one pixel remembers; see `emulator.pixels.PixelState`."""

    lag: float
    change: float
    leak: float
    clock: float
    busy_us: float
    draws: np.int64


class Threshold(NamedTuple):
    """What mismatch has made of one pixel; see `emulator.pixels.FrozenMaps`."""

    on: float
    off: float
    hot_rate: float


class Stretch(NamedTuple):
    """A stretch of time on which u is straight and all rates are constant.

    Attributes:
        slope: of u [ln units/µs].
        tau_us: time constant τ of the photoreceptor [µs].
        corner: 1/τ [1/µs].
        shot_on: rate of ON shot noise [events/µs].
        shot_off: rate of OFF shot noise [events/µs].
        noise_rate: rate of all noise events, hot pixels included [events/µs].
        leak_drift: of the memorised value [ln units/µs].
    """

    slope: float
    tau_us: float
    corner: float
    shot_on: float
    shot_off: float
    noise_rate: float
    leak_drift: float


@compiled
def stretch_of(
    model: PixelModel, threshold: Threshold, log_from: float, log_to: float, span_us: float
) -> Stretch:
    """Stretch of `span_us` along which u goes from `log_from` to `log_to`; rates are half-way's."""
    middle = 0.5 * (log_from + log_to)
    current_lux = math.exp(middle)
    corner = corner_per_us(current_lux, model.corner_per_lux, model.corner_limit)
    shot_on, shot_off = shot_rates(model.noise, middle)
    return Stretch(
        (log_to - log_from) / span_us,
        1.0 / corner,
        corner,
        shot_on,
        shot_off,
        shot_on + shot_off + threshold.hot_rate,
        leak_drift(model.noise, current_lux),
    )


@compiled
def follow(pixel: Pixel, stretch: Stretch, span_us: float, decay: float) -> Pixel:
    """Pixel after `span_us` without an event; `decay` is exp(−span/τ)."""
    lag = lag_after(pixel.lag, stretch.slope, stretch.tau_us, decay)
    return Pixel(
        lag,
        pixel.change + stretch.slope * span_us - (lag - pixel.lag),
        pixel.leak + stretch.leak_drift * span_us,
        pixel.clock - stretch.noise_rate * span_us,
        0.0,
        pixel.draws,
    )


@compiled
def hold_in_reset(pixel: Pixel, stretch: Stretch, span_us: float) -> Pixel:
    """Pixel after `span_us` of its refractory period, in which it follows and counts nothing."""
    decay = math.exp(-span_us * stretch.corner)
    lag = lag_after(pixel.lag, stretch.slope, stretch.tau_us, decay)
    return Pixel(lag, 0.0, 0.0, pixel.clock, pixel.busy_us - span_us, pixel.draws)


@compiled
def after_event(pixel: Pixel, refractory_us: float) -> Pixel:
    """Pixel that has memorised the present value."""
    return Pixel(pixel.lag, 0.0, 0.0, pixel.clock, refractory_us, pixel.draws)


@compiled
def crossing_mark(pixel: Pixel, on: bool) -> int:
    """Cause and polarity of a crossing: leak's where it drifted further than the signal moved."""
    if not on:
        return _SIGNAL_OFF
    return _LEAK_ON if pixel.leak > pixel.change else _SIGNAL_ON


@compiled
def noise_event(pixel: Pixel, stretch: Stretch, model: PixelModel, index: int) -> tuple[Pixel, int]:
    """Pixel with its clock wound up again, and the cause and polarity of what fired.

    A hot pixel is taken to fire ON (assumed: its current discharges the node as leak does).
    """
    share = uniform(model.seed, index, pixel.draws) * stretch.noise_rate
    clock = exponential(model.seed, index, pixel.draws + 1)
    pixel = Pixel(pixel.lag, pixel.change, pixel.leak, clock, pixel.busy_us, pixel.draws + 2)
    if share < stretch.shot_on:
        return pixel, _SHOT_ON
    if share < stretch.shot_on + stretch.shot_off:
        return pixel, _SHOT_OFF
    return pixel, _HOT_ON


@inlined
def follow_to_event(
    pixel: Pixel,
    stretch: Stretch,
    threshold: Threshold,
    model: PixelModel,
    index: int,
    left_us: float,
) -> tuple[Pixel, float, int]:
    """Take a pixel to its next event, or to the end of its refractory period or of the stretch.

    Args:
        pixel: before.
        stretch: what it sees.
        threshold: what mismatch made of it.
        model: constants of the sensor.
        index: its place in the array, for its random numbers.
        left_us: what is left of the stretch [µs].

    Returns:
        The pixel then, the time that it took [µs], and 2·cause + polarity or `NO_EVENT`.
    """
    if pixel.busy_us > 0.0:
        wait_us = min(pixel.busy_us, left_us)
        return hold_in_reset(pixel, stretch, wait_us), wait_us, NO_EVENT
    noisy = pixel.clock <= stretch.noise_rate * left_us
    reach_us = max(0.0, pixel.clock / stretch.noise_rate) if noisy else left_us
    tau_us = stretch.tau_us
    decay = math.exp(-reach_us * stretch.corner)
    level = pixel.change + pixel.leak
    rate = stretch.slope + stretch.leak_drift
    swing = pixel.lag - stretch.slope * tau_us
    if not stays_within(level, rate, swing, tau_us, reach_us, decay, threshold.on, threshold.off):
        crossing_us, on = first_crossing(
            level, rate, swing, tau_us, reach_us, threshold.on, threshold.off
        )
        if crossing_us < NEVER_US:
            pixel = follow(pixel, stretch, crossing_us, math.exp(-crossing_us * stretch.corner))
            mark = crossing_mark(pixel, on)
            return after_event(pixel, model.refractory_us), crossing_us, mark
    pixel = follow(pixel, stretch, reach_us, decay)
    if not noisy:
        return pixel, reach_us, NO_EVENT
    pixel, mark = noise_event(pixel, stretch, model, index)
    return after_event(pixel, model.refractory_us), reach_us, mark


@compiled
def earliest_event_us(pixel: Pixel, stretch: Stretch, threshold: Threshold) -> float:
    """How long a pixel surely stays silent on a stretch of constant light [µs]."""
    level = pixel.change + pixel.leak
    highest = level + max(pixel.lag, 0.0) + _WAKE_MARGIN
    lowest = level + min(pixel.lag, 0.0) - _WAKE_MARGIN
    if pixel.busy_us > 0.0 or highest >= threshold.on or lowest <= -threshold.off:
        return 0.0
    noise_us = pixel.clock / stretch.noise_rate
    leak_us = (threshold.on - highest) / stretch.leak_drift
    return max(0.0, min(noise_us, leak_us, _FAR_US))
