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
from emulator.pixel import fields as at
from emulator.pixel.batch import Batch, Reals, rounded_up
from emulator.pixel.noisy.near_batch import spend_clocks
from emulator.pixel.photoreceptor import inverse_tau_per_us, lag_after, log_current
from emulator.pixel.source_follower import second_lag_after
from emulator.pixel.state import MOVED, PixelModel, PixelState
from flybench.kernels import compiled
from flybench.portable_math import exp

_COPIED = (
    at.LAG,
    at.SECOND_LAG,
    at.CHANGE,
    at.LEAK,
    at.CLOCK,
    at.THETA_ON,
    at.THETA_OFF,
    at.DARK_LUX,
    at.LEAK_FACTOR,
    at.LUMINANCE_FROM,
    at.LUMINANCE_TO,
    at.REST,
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
        if own[at.REST + m] == 0.0:
            i = int(batch.indices[batch.crossing[m]])
            draw = np.int64(state.pixels[i].draws & ~MOVED) - 1
            own[at.GAUSSIAN + m] = gaussian(model.seed, i, draw)
    hold_in_reset(own, model, rounded, span_us)
    _return_waiting(batch, waiting)


@compiled
def _gather(batch: Batch, count: int) -> int:
    """Copy the pixels that sleep, or else are in reset, to `crossing_fields`; return how many."""
    fields, positions, own = batch.fields, batch.crossing, batch.crossing_fields
    found = 0
    for k in range(count):
        asleep, held = fields[at.REST + k] != 0.0, fields[at.LEAK + k] < 0.0
        positions[found] = k
        found += batch.changed[k] & (asleep != held) & (fields[at.HOT_RATE + k] == 0.0)
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
        dark_lux, slept_us = own[at.DARK_LUX + k], -own[at.REST + k]
        log_from = log_current(own[at.LUMINANCE_FROM + k] * per_cd_m2, dark_lux)
        log_to = log_current(own[at.LUMINANCE_TO + k] * per_cd_m2, dark_lux)
        log_to = log_from if slept_us > 0.0 else log_to
        current_lux = exp(0.5 * (log_from + log_to))
        corner = inverse_tau_per_us(current_lux, model.corner_per_lux, model.corner_limit)
        open_corner = model.corner_per_lux * current_lux
        own[at.CORNER + k] = corner
        own[at.DRIFT + k] = leak_drift(model.leak, current_lux - dark_lux, own[at.LEAK_FACTOR + k])
        own[at.SIGMA + k] = noise_of(model.sigma_0, corner, open_corner, model.follower_us).sigma
        own[at.SLOPE + k] = (log_to - log_from) / span_us
        own[at.SPAN + k] = slept_us
        own[at.RESET + k] = max(-own[at.LEAK + k], 0.0)
        own[at.START + k] = 0.0


@compiled
def follow(own: Reals, model: PixelModel, count: int) -> None:
    """Follow the first `count` pixels through SPAN without an event."""
    has_follower = model.follower_us > 0.0
    for k in range(count):
        lag, second_lag = own[at.LAG + k], own[at.SECOND_LAG + k]
        span_us, slope, tau_us = own[at.SPAN + k], own[at.SLOPE + k], 1.0 / own[at.CORNER + k]
        new_lag = lag_after(lag, slope, tau_us, exp(-span_us * own[at.CORNER + k]))
        new_second = 0.0
        if has_follower:
            new_second = second_lag_after(
                lag, second_lag, slope, tau_us, model.follower_us, span_us
            )
        own[at.NEW_LAG + k] = new_lag
        own[at.NEW_SECOND_LAG + k] = new_second
        own[at.NEW_CHANGE + k] = (
            own[at.CHANGE + k] + slope * span_us - (new_lag - lag) - (new_second - second_lag)
        )
        own[at.NEW_LEAK + k] = own[at.LEAK + k] + own[at.DRIFT + k] * span_us


@compiled
def hold_in_reset(own: Reals, model: PixelModel, count: int, span_us: float) -> None:
    """Hold the first `count` pixels in reset from START, for RESET or to the end of the step.

    If the reset ends, the memory takes the noise of that moment; see
    `emulator.pixel.noisy.advance.leave_reset`. START, SPAN and RESET are set to what is left.
    """
    has_follower = model.follower_us > 0.0
    for k in range(count):
        lag, slope, corner = own[at.LAG + k], own[at.SLOPE + k], own[at.CORNER + k]
        tau_us, left_us = 1.0 / corner, span_us - own[at.START + k]
        hold_us = min(own[at.RESET + k], left_us)
        ends = own[at.RESET + k] <= left_us
        noise = noise_of(own[at.SIGMA + k], corner, corner, model.follower_us)
        drawn = math.sqrt(1.0 - exp(-2.0 * model.refractory_us * noise.per_tau))
        new_lag = lag_after(lag, slope, tau_us, exp(-hold_us * corner))
        if has_follower:
            own[at.SECOND_LAG + k] = second_lag_after(
                lag, own[at.SECOND_LAG + k], slope, tau_us, model.follower_us, hold_us
            )
        own[at.LAG + k] = new_lag - (
            own[at.SIGMA + k] * drawn * own[at.GAUSSIAN + k] if ends else 0.0
        )
        own[at.CHANGE + k] = 0.0
        own[at.LEAK + k] = 0.0
        own[at.RESET + k] -= hold_us
        own[at.START + k] += hold_us
        own[at.SPAN + k] = left_us - hold_us


@compiled
def _return_waiting(batch: Batch, count: int) -> None:
    """Copy the first `count` pixels back to their batch, unless they have fired in their sleep."""
    fields, own = batch.fields, batch.crossing_fields
    for m in range(count):
        k = int(batch.crossing[m])
        if own[at.REST + m] == 0.0:
            fields[at.LAG + k] = own[at.LAG + m]
            fields[at.SECOND_LAG + k] = own[at.SECOND_LAG + m]
            fields[at.CHANGE + k] = 0.0
            fields[at.LEAK + k] = -own[at.RESET + m]
            fields[at.START + k] = own[at.START + m]
        elif own[at.NEW_CLOCK + m] > 0.0:
            fields[at.LAG + k] = own[at.NEW_LAG + m]
            fields[at.SECOND_LAG + k] = own[at.NEW_SECOND_LAG + m]
            fields[at.CHANGE + k] = own[at.NEW_CHANGE + m]
            fields[at.LEAK + k] = own[at.NEW_LEAK + m]
            fields[at.CLOCK + k] = own[at.NEW_CLOCK + m]
            fields[at.REST + k] = 0.0
