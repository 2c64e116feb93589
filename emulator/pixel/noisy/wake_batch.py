"""Brings the pixels of a batch that sleep or are held in reset to the ramp of a step.

A sleeping pixel is followed through the constant light to the start of the step; a pixel in reset
is held until its reset ends, or to the end of the step. Then they are followed as the others. Those
that fire meanwhile are left as they are, for `emulator.pixel.noisy.step`.
"""

from __future__ import annotations

import math

import numpy as np

from emulator.noise.leak import leak_drift
from emulator.noise.photoreceptor_noise import noise_of
from emulator.noise.random_numbers import gaussian
from emulator.pixel.batch import (
    CHANGE,
    CLOCK,
    CORNER,
    DARK_LUX,
    DRIFT,
    GAUSSIAN,
    HOT_RATE,
    LAG,
    LEAK,
    LEAK_FACTOR,
    LUMINANCE_FROM,
    LUMINANCE_TO,
    NEW_CHANGE,
    NEW_CLOCK,
    NEW_LAG,
    NEW_LEAK,
    NEW_SECOND_LAG,
    RESET,
    REST,
    SECOND_LAG,
    SIGMA,
    SLOPE,
    SPAN,
    START,
    THETA_OFF,
    THETA_ON,
    Batch,
    Reals,
    rounded_up,
)
from emulator.pixel.noisy.near_batch import spend_clocks
from emulator.pixel.photoreceptor import inverse_tau_per_us, lag_after, log_current
from emulator.pixel.source_follower import second_lag_after
from emulator.pixel.state import MOVED, PixelModel, PixelState
from flybench.kernels import compiled
from flybench.portable_math import exp

_COPIED = (
    LAG,
    SECOND_LAG,
    CHANGE,
    LEAK,
    CLOCK,
    THETA_ON,
    THETA_OFF,
    DARK_LUX,
    LEAK_FACTOR,
    LUMINANCE_FROM,
    LUMINANCE_TO,
    REST,
)
"""Fields that the pass reads."""


@compiled
def bring_to_ramp(
    batch: Batch, state: PixelState, model: PixelModel, count: int, span_us: float
) -> None:
    """Bring pixels that sleep or are in reset to the ramp, among the first `count` of a batch.

    START is set to the time of their state, from the start of the step, and REST to 0.
    """
    own = batch.crossing_fields
    waiting = _gather(batch, count)
    if waiting == 0:
        return
    rounded = rounded_up(waiting)
    _set_light(own, model, rounded, span_us)
    spend_clocks(own, model, rounded)
    follow(own, model, rounded)
    for m in range(waiting):
        if own[REST + m] == 0.0:
            i = int(batch.indices[batch.crossing[m]])
            draw = np.int64(state.pixels[i].draws & ~MOVED) - 1
            own[GAUSSIAN + m] = gaussian(model.seed, i, draw)
    hold_in_reset(own, model, rounded, span_us)
    _return_waiting(batch, waiting)


@compiled
def _gather(batch: Batch, count: int) -> int:
    """Copy the pixels that sleep, or else are in reset, to `crossing_fields`; return how many."""
    fields, positions, own = batch.fields, batch.crossing, batch.crossing_fields
    found = 0
    for k in range(count):
        asleep, held = fields[REST + k] != 0.0, fields[LEAK + k] < 0.0
        positions[found] = k
        found += batch.changed[k] & (asleep != held) & (fields[HOT_RATE + k] == 0.0)
    for field in _COPIED:
        for m in range(found):
            own[field + m] = fields[field + positions[m]]
    return found


@compiled
def _set_light(own: Reals, model: PixelModel, count: int, span_us: float) -> None:
    """Set what the light determines: that before the step for sleeping pixels, else the ramp.

    SPAN is the time that a pixel has slept, RESET what is left of its reset.
    """
    per_cd_m2 = model.lux_per_cd_m2
    for k in range(count):
        dark_lux, slept_us = own[DARK_LUX + k], -own[REST + k]
        log_from = log_current(own[LUMINANCE_FROM + k] * per_cd_m2, dark_lux)
        log_to = log_current(own[LUMINANCE_TO + k] * per_cd_m2, dark_lux)
        log_to = log_from if slept_us > 0.0 else log_to
        current_lux = exp(0.5 * (log_from + log_to))
        corner = inverse_tau_per_us(current_lux, model.corner_per_lux, model.corner_limit)
        open_corner = model.corner_per_lux * current_lux
        own[CORNER + k] = corner
        own[DRIFT + k] = leak_drift(model.leak, current_lux - dark_lux, own[LEAK_FACTOR + k])
        own[SIGMA + k] = noise_of(model.sigma_0, corner, open_corner, model.follower_us).sigma
        own[SLOPE + k] = (log_to - log_from) / span_us
        own[SPAN + k] = slept_us
        own[RESET + k] = max(-own[LEAK + k], 0.0)
        own[START + k] = 0.0


@compiled
def follow(own: Reals, model: PixelModel, count: int) -> None:
    """Follow the first `count` pixels through SPAN without an event."""
    has_follower = model.follower_us > 0.0
    for k in range(count):
        lag, second_lag = own[LAG + k], own[SECOND_LAG + k]
        span_us, slope, tau_us = own[SPAN + k], own[SLOPE + k], 1.0 / own[CORNER + k]
        new_lag = lag_after(lag, slope, tau_us, exp(-span_us * own[CORNER + k]))
        new_second = 0.0
        if has_follower:
            new_second = second_lag_after(
                lag, second_lag, slope, tau_us, model.follower_us, span_us
            )
        own[NEW_LAG + k] = new_lag
        own[NEW_SECOND_LAG + k] = new_second
        own[NEW_CHANGE + k] = (
            own[CHANGE + k] + slope * span_us - (new_lag - lag) - (new_second - second_lag)
        )
        own[NEW_LEAK + k] = own[LEAK + k] + own[DRIFT + k] * span_us


@compiled
def hold_in_reset(own: Reals, model: PixelModel, count: int, span_us: float) -> None:
    """Hold the first `count` pixels in reset from START, for RESET or to the end of the step.

    If the reset ends, the memory takes the noise of that moment; see
    `emulator.pixel.noisy.advance.leave_reset`. START, SPAN and RESET are set to what is left.
    """
    has_follower = model.follower_us > 0.0
    for k in range(count):
        lag, slope, corner = own[LAG + k], own[SLOPE + k], own[CORNER + k]
        tau_us, left_us = 1.0 / corner, span_us - own[START + k]
        hold_us = min(own[RESET + k], left_us)
        ends = own[RESET + k] <= left_us
        noise = noise_of(own[SIGMA + k], corner, corner, model.follower_us)
        drawn = math.sqrt(1.0 - exp(-2.0 * model.refractory_us * noise.per_tau))
        new_lag = lag_after(lag, slope, tau_us, exp(-hold_us * corner))
        if has_follower:
            own[SECOND_LAG + k] = second_lag_after(
                lag, own[SECOND_LAG + k], slope, tau_us, model.follower_us, hold_us
            )
        own[LAG + k] = new_lag - (own[SIGMA + k] * drawn * own[GAUSSIAN + k] if ends else 0.0)
        own[CHANGE + k] = 0.0
        own[LEAK + k] = 0.0
        own[RESET + k] -= hold_us
        own[START + k] += hold_us
        own[SPAN + k] = left_us - hold_us


@compiled
def _return_waiting(batch: Batch, count: int) -> None:
    """Copy the first `count` pixels back to their batch, unless they have fired in their sleep."""
    fields, own = batch.fields, batch.crossing_fields
    for m in range(count):
        k = int(batch.crossing[m])
        if own[REST + m] == 0.0:
            fields[LAG + k] = own[LAG + m]
            fields[SECOND_LAG + k] = own[SECOND_LAG + m]
            fields[CHANGE + k] = 0.0
            fields[LEAK + k] = -own[RESET + m]
            fields[START + k] = own[START + m]
        elif own[NEW_CLOCK + m] > 0.0:
            fields[LAG + k] = own[NEW_LAG + m]
            fields[SECOND_LAG + k] = own[NEW_SECOND_LAG + m]
            fields[CHANGE + k] = own[NEW_CHANGE + m]
            fields[LEAK + k] = own[NEW_LEAK + m]
            fields[CLOCK + k] = own[NEW_CLOCK + m]
            fields[REST + k] = 0.0
