"""One event pixel on its way to its next event.

Threshold crossings and noise compete; the first one resets the pixel. While the pixel is
refractory the memorised value follows the photoreceptor, so what changes meanwhile is lost
(Lichtsteiner, Posch, Delbruck 2008). A noise event resets the pixel as any other does.

The functions pass one pixel's numbers by value, as tuples of scalars: the compiler keeps those in
registers, where arrays handed from function to function would cost a reference count each.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from emulator.pixel.change_detector import NEVER_US, first_crossing, stays_within
from emulator.pixel.noise import exponential, leak_drift, shot_rates, uniform
from emulator.pixel.photoreceptor import corner_per_us, lag_after
from emulator.pixel.source_follower import amplitudes, behind_after, first_crossing_behind, unlike
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
"""How far from a threshold a pixel may sleep [ln units]: well above the rounding of its state."""

LONGEST_SLEEP_US = 2.0**30
"""How long a pixel may sleep: its times are kept modulo 2^32 µs."""


class Pixel(NamedTuple):
    """What one pixel remembers; see `emulator.pixel.state.PIXEL_DTYPE`."""

    lag: float
    change: float
    leak: float
    clock: float
    busy_us: float
    draws: np.int64
    behind: float


class Threshold(NamedTuple):
    """What mismatch has made of one pixel; see `emulator.pixel.state.PIXEL_DTYPE`."""

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


@inlined
def stretch_of(
    model: PixelModel, threshold: Threshold, log_from: float, log_to: float, span_us: float
) -> Stretch:
    """Stretch of `span_us` along which u goes from `log_from` to `log_to`; rates are half-way's."""
    middle = 0.5 * (log_from + log_to)
    current_lux = exp(middle)
    corner = corner_per_us(current_lux, model.corner_per_lux, model.corner_limit)
    shot_on, shot_off = shot_rates(model.noise, middle)
    return Stretch(
        (log_to - log_from) / span_us,
        1.0 / corner,
        corner,
        shot_on,
        shot_off,
        shot_on + shot_off + abs(threshold.hot_rate),
        leak_drift(model.noise, current_lux),
    )


@inlined
def lags_after(
    pixel: Pixel, stretch: Stretch, model: PixelModel, span_us: float, decay: float
) -> tuple[float, float]:
    """Lags of the photoreceptor and of its follower after `span_us`; `decay` is exp(−span/τ)."""
    lag = lag_after(pixel.lag, stretch.slope, stretch.tau_us, decay)
    if model.follower_us == 0.0:
        return lag, 0.0
    return lag, behind_after(
        pixel.lag, pixel.behind, stretch.slope, stretch.tau_us, model.follower_us, span_us
    )


@inlined
def follow(
    pixel: Pixel, stretch: Stretch, model: PixelModel, span_us: float, decay: float
) -> Pixel:
    """Pixel after `span_us` without an event; `decay` is exp(−span/τ)."""
    lag, behind = lags_after(pixel, stretch, model, span_us, decay)
    return Pixel(
        lag,
        pixel.change + stretch.slope * span_us - (lag - pixel.lag) - (behind - pixel.behind),
        pixel.leak + stretch.leak_drift * span_us,
        pixel.clock - stretch.noise_rate * span_us,
        0.0,
        pixel.draws,
        behind,
    )


@inlined
def hold_in_reset(
    pixel: Pixel, stretch: Stretch, model: PixelModel, after_us: float, hold_us: float
) -> Pixel:
    """Pixel that goes on for `after_us`, and then follows and counts nothing for `hold_us`."""
    span_us = after_us + hold_us
    lag, behind = lags_after(pixel, stretch, model, span_us, exp(-span_us * stretch.corner))
    clock = pixel.clock - stretch.noise_rate * after_us
    return Pixel(lag, 0.0, 0.0, clock, pixel.busy_us - hold_us, pixel.draws, behind)


@inlined
def crossing_mark(leak: float, theta_on: float, on: bool) -> int:
    """Cause and polarity of a crossing: leak's where it drifted further than the signal moved.

    Args:
        leak: how far leak has drifted [ln units].
        theta_on: ON threshold, which leak and signal have reached together [ln units].
        on: whether it is the ON threshold that was crossed.
    """
    if not on:
        return _SIGNAL_OFF
    return _LEAK_ON if leak > theta_on - leak else _SIGNAL_ON


@compiled
def noise_event(
    pixel: Pixel, stretch: Stretch, hot_rate: float, model: PixelModel, index: int
) -> tuple[Pixel, int]:
    """Pixel with its clock wound up again, and the cause and polarity of what fired.

    A hot pixel is taken to fire ON (assumed: its current discharges the node as leak does), a
    crazy one, whose rate is kept negative, ON and OFF equally often (assumed).
    """
    share = uniform(model.seed, index, pixel.draws) * stretch.noise_rate
    clock = exponential(model.seed, index, pixel.draws + 1)
    pixel = Pixel(
        pixel.lag,
        pixel.change,
        pixel.leak,
        clock,
        pixel.busy_us,
        pixel.draws + 2,
        pixel.behind,
    )
    shot = stretch.shot_on + stretch.shot_off
    if share < stretch.shot_on:
        return pixel, _SHOT_ON
    if share < shot:
        return pixel, _SHOT_OFF
    return pixel, _HOT_OFF if share - shot < -0.5 * hot_rate else _HOT_ON


@inlined
def reset_at(
    pixel: Pixel, stretch: Stretch, model: PixelModel, at_us: float, left_us: float
) -> tuple[Pixel, float]:
    """Pixel that has an event in `at_us`, at the end of its reset or of the stretch, and that time.

    Args:
        pixel: before.
        stretch: what it sees.
        model: constants of the sensor.
        at_us: when the event is [µs].
        left_us: what is left of the stretch [µs].
    """
    hold_us = min(model.refractory_us, left_us - at_us)
    waiting = Pixel(
        pixel.lag, 0.0, 0.0, pixel.clock, model.refractory_us, pixel.draws, pixel.behind
    )
    return hold_in_reset(waiting, stretch, model, at_us, hold_us), at_us + hold_us


@inlined
def next_crossing(
    pixel: Pixel,
    stretch: Stretch,
    threshold: Threshold,
    model: PixelModel,
    reach_us: float,
    decay: float,
) -> tuple[float, bool]:
    """First crossing of a threshold within `reach_us`, and whether it is ON; see `first_crossing`.

    Args:
        pixel: before.
        stretch: what it sees.
        threshold: what mismatch made of it.
        model: constants of the sensor.
        reach_us: how far to look [µs].
        decay: exp(−reach/τ).
    """
    level = pixel.change + pixel.leak
    rate = stretch.slope + stretch.leak_drift
    tau_us, theta_on, theta_off = stretch.tau_us, threshold.on, threshold.off
    if model.follower_us > 0.0:
        follower_us = unlike(tau_us, model.follower_us)
        a, b = amplitudes(pixel.lag, pixel.behind, stretch.slope, tau_us, follower_us)
        return first_crossing_behind(
            level, rate, a, b, tau_us, follower_us, reach_us, theta_on, theta_off
        )
    swing = pixel.lag - stretch.slope * tau_us
    if stays_within(level, rate, swing, tau_us, reach_us, decay, theta_on, theta_off):
        return NEVER_US, False
    return first_crossing(level, rate, swing, tau_us, reach_us, theta_on, theta_off)


@inlined
def follow_to_event(
    pixel: Pixel,
    stretch: Stretch,
    threshold: Threshold,
    model: PixelModel,
    index: int,
    left_us: float,
) -> tuple[Pixel, float, float, int]:
    """Take a pixel through its next event and the reset after it, or to the end of the stretch.

    Args:
        pixel: before.
        stretch: what it sees.
        threshold: what mismatch made of it.
        model: constants of the sensor.
        index: its place in the array, for its random numbers.
        left_us: what is left of the stretch [µs].

    Returns:
        The pixel then, the time that it took [µs], the time of the event [µs], and 2·cause +
        polarity or `NO_EVENT`.
    """
    if pixel.busy_us > 0.0:
        wait_us = min(pixel.busy_us, left_us)
        return hold_in_reset(pixel, stretch, model, 0.0, wait_us), wait_us, 0.0, NO_EVENT
    noisy = pixel.clock <= stretch.noise_rate * left_us
    reach_us = max(0.0, pixel.clock / stretch.noise_rate) if noisy else left_us
    decay = exp(-reach_us * stretch.corner)
    crossing_us, on = next_crossing(pixel, stretch, threshold, model, reach_us, decay)
    if crossing_us < NEVER_US:
        leak = pixel.leak + stretch.leak_drift * crossing_us
        pixel, spent_us = reset_at(pixel, stretch, model, crossing_us, left_us)
        return pixel, spent_us, crossing_us, crossing_mark(leak, threshold.on, on)
    if not noisy:
        return follow(pixel, stretch, model, reach_us, decay), reach_us, 0.0, NO_EVENT
    pixel, spent_us = reset_at(pixel, stretch, model, reach_us, left_us)
    pixel, mark = noise_event(pixel, stretch, threshold.hot_rate, model, index)
    return pixel, spent_us, reach_us, mark


@inlined
def earliest_event_us(pixel: Pixel, threshold: Threshold, noise_rate: float, drift: float) -> float:
    """How long a pixel in constant light surely stays silent [µs].

    Args:
        pixel: its numbers.
        threshold: what mismatch made of it.
        noise_rate: of all noise events [events/µs].
        drift: of the memorised value by leak [ln units/µs].
    """
    level = pixel.change + pixel.leak
    total = pixel.lag + pixel.behind
    highest = level + max(total, pixel.behind, 0.0) + _WAKE_MARGIN
    lowest = level + min(total, pixel.behind, 0.0) - _WAKE_MARGIN
    if pixel.busy_us > 0.0 or highest >= threshold.on or lowest <= -threshold.off:
        return 0.0
    silent_us = min(pixel.clock / noise_rate, (threshold.on - highest) / drift)
    return max(0.0, min(silent_us, LONGEST_SLEEP_US))
