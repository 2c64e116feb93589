"""Lets noisy pixels settle to a scene, so that a recording does not begin with a burst.

A pixel that has looked at the scene for a long time has fired and been reset at random. Its leak
phase and its noise cannot be drawn from a simple distribution. Each pixel is therefore taken
through still light before the first sample, as long as its events need to forget the start. Many
pixels are followed at once, each through a span of its own: a short one while its output still
lags, else to its next event.
"""

from __future__ import annotations

import math

import numpy as np

from emulator.noise.leak import leak_drift
from emulator.noise.photoreceptor_noise import noise_of
from emulator.pixel import fields as at
from emulator.pixel.batch import SILENT, Batch, Reals, rounded_up
from emulator.pixel.batch_events import stored_pixel
from emulator.pixel.fields import BATCH
from emulator.pixel.noisy.advance import advance_noisy
from emulator.pixel.noisy.fire_batch import fire_and_hold
from emulator.pixel.noisy.near_batch import KEPT, spend_clocks
from emulator.pixel.noisy.wake_batch import follow
from emulator.pixel.photoreceptor import inverse_tau_per_us, log_current
from emulator.pixel.segment import Mismatch, make_segment
from emulator.pixel.state import BLOCK, DRAWS, PixelModel, PixelState
from flybench.kernels import compiled
from flybench.portable_math import exp

EVENTS, STAGE = at.EARLIEST, at.LATEST
"""Fields for the number of events and of spans so far."""

_CARRIED = (
    at.LAG,
    at.SECOND_LAG,
    at.CHANGE,
    at.LEAK,
    at.CLOCK,
    at.THETA_ON,
    at.THETA_OFF,
    at.DRIFT,
    at.CORNER,
    at.SIGMA,
    at.RESET,
    at.START,
    EVENTS,
    STAGE,
)
"""Fields that a pixel keeps from round to round."""

_SPANS_US = (0.2e6, 0.4e6, 1.4e6, 4e6, 14e6)
"""Spans after each of which a pixel may have settled. Their sum is the time that the leak of the
median pixel needs from one event to the next (assumed to suffice)."""

_EVENTS = 16
"""Number of events by which a pixel must have fired to settle before the longest time (assumed)."""

_LAG = 0.05
"""Lag in σ below which the output follows the leak alone (assumed)."""

_SHORT, _LONG = 1.0, 2.5
"""Spans while the lag is above σ, and while it is above `_LAG`, in correlation times of the noise:
long enough to be cheap, short enough for d to be nearly straight (assumed)."""

_NEWTON_STEPS = 24
"""Most steps of Newton's method: the hazard of a slow leak grows by orders of magnitude."""


@compiled
def settle(state: PixelState, model: PixelModel, batch: Batch) -> None:
    """Let all pixels settle to the luminance of the state, which is changed in place.

    Args:
        state: state of all pixels, as drawn.
        model: constants of the sensor.
        batch: an empty batch.
    """
    for first in range(0, state.pixels.size, BATCH):
        count = _load(batch, state, model, first)
        _settle_batch(batch, state, model, count)
    _plan_sleep(state, model)


@compiled
def _load(batch: Batch, state: PixelState, model: PixelModel, first: int) -> int:
    """Load the pixels of a batch that need to settle, from index `first`; return their number.

    Hot pixels fire soon anyway, and dead pixels never.
    """
    own, found = batch.fields, 0
    for i in range(first, min(first + BATCH, state.pixels.size)):
        pixel = state.pixels[i]
        if pixel.hot_rate != 0.0 or pixel.theta_on == np.inf:
            continue
        dark_lux = pixel.dark_factor * model.dark_lux
        current_lux = exp(log_current(state.luminance[i] * model.lux_per_cd_m2, dark_lux))
        corner = inverse_tau_per_us(current_lux, model.corner_per_lux, model.corner_limit)
        open_corner = model.corner_per_lux * current_lux
        batch.indices[found] = i
        own[at.LAG + found] = own[at.SECOND_LAG + found] = own[at.CHANGE + found] = 0.0
        own[at.LEAK + found] = pixel.leak
        own[at.CLOCK + found] = pixel.clock
        own[at.THETA_ON + found] = pixel.theta_on
        own[at.THETA_OFF + found] = pixel.theta_off
        own[at.DRIFT + found] = leak_drift(model.leak, current_lux - dark_lux, pixel.leak_factor)
        own[at.CORNER + found] = corner
        own[at.SIGMA + found] = noise_of(
            model.sigma_0, corner, open_corner, model.follower_us
        ).sigma
        own[at.SLOPE + found] = own[at.RESET + found] = 0.0
        own[at.START + found] = -_SPANS_US[0]
        own[STAGE + found] = own[EVENTS + found] = 0.0
        found += 1
    return found


@compiled
def _settle_batch(batch: Batch, state: PixelState, model: PixelModel, count: int) -> None:
    """Settle the first `count` pixels of a batch. START runs to 0 at the end of each span."""
    own, other, firing = batch.fields, batch.crossing_fields, batch.crossing
    while count > 0:
        _choose_spans(own, model, rounded_up(count))
        spend_clocks(own, model, rounded_up(count))
        follow(own, model, rounded_up(count))
        found = 0
        for k in range(count):
            if own[at.NEW_CLOCK + k] <= 0.0:
                firing[found] = k
                found += 1
        for field in KEPT:
            for m in range(found):
                other[field + m] = own[field + firing[m]]
        _keep(own, rounded_up(count))
        fire_and_hold(batch, state, model, found, 0.0, _NEWTON_STEPS)
        _return_fired(batch, state, found)
        count = _finish_spans(batch, state, count)


@compiled
def _choose_spans(own: Reals, model: PixelModel, count: int) -> None:
    """Set SPAN of the first `count` pixels: to the end of their span, or shorter while they lag."""
    for k in range(count):
        lag = abs(own[at.LAG + k]) + abs(own[at.SECOND_LAG + k])
        sigma, tau_us = own[at.SIGMA + k], 1.0 / own[at.CORNER + k] + model.follower_us
        piece_us = tau_us * (_SHORT if lag > sigma else _LONG)
        left_us = -own[at.START + k]
        own[at.SPAN + k] = min(left_us, piece_us) if lag > _LAG * sigma else left_us


@compiled
def _keep(own: Reals, count: int) -> None:
    """Move the first `count` pixels to the end of their SPAN, where they have not fired."""
    for k in range(count):
        own[at.LAG + k] = own[at.NEW_LAG + k]
        own[at.SECOND_LAG + k] = own[at.NEW_SECOND_LAG + k]
        own[at.CHANGE + k] = own[at.NEW_CHANGE + k]
        own[at.LEAK + k] = own[at.NEW_LEAK + k]
        own[at.CLOCK + k] = own[at.NEW_CLOCK + k]
        own[at.START + k] += own[at.SPAN + k]


@compiled
def _return_fired(batch: Batch, state: PixelState, count: int) -> None:
    """Copy the first `count` pixels that have fired back; rounding may have kept some silent."""
    own, other = batch.fields, batch.crossing_fields
    for m in range(count):
        k = int(batch.crossing[m])
        if other[at.OUTCOME + m] == SILENT:
            own[at.CLOCK + k] = other[at.USED + m]
            continue
        own[at.LAG + k] = other[at.LAG + m]
        own[at.SECOND_LAG + k] = other[at.SECOND_LAG + m]
        own[at.CHANGE + k] = own[at.LEAK + k] = 0.0
        own[at.CLOCK + k] = other[at.CLOCK + m]
        own[at.START + k] = other[at.START + m]
        own[at.RESET + k] = other[at.RESET + m]
        own[EVENTS + k] += 1.0
        state.pixels[batch.indices[k]].draws += DRAWS


@compiled
def _finish_spans(batch: Batch, state: PixelState, count: int) -> int:
    """Store pixels that have settled, begin the next span of the others; return how many those are.

    A reset is cut short where a span ends and another begins, which is rare.
    """
    own, k = batch.fields, 0
    while k < count:
        stage = int(own[STAGE + k])
        if own[at.START + k] < 0.0:
            k += 1
        elif stage + 1 < len(_SPANS_US) and own[EVENTS + k] < _EVENTS:
            own[STAGE + k] += 1.0
            own[at.START + k] = -_SPANS_US[stage + 1]
            own[at.RESET + k] = 0.0
            k += 1
        else:
            pixel = state.pixels[batch.indices[k]]
            pixel.lag = own[at.LAG + k]
            pixel.second_lag = own[at.SECOND_LAG + k]
            pixel.change = own[at.CHANGE + k]
            pixel.leak = own[at.LEAK + k] - math.ceil(own[at.RESET + k])
            pixel.clock = own[at.CLOCK + k]
            count -= 1
            batch.indices[k] = batch.indices[count]
            for field in _CARRIED:
                own[field + k] = own[field + count]
    return count


@compiled
def _plan_sleep(state: PixelState, model: PixelModel) -> None:
    """Let each pixel sleep to its next event or to the end of a piece of time."""
    wake_us = state.wake_us
    for i in range(state.pixels.size):
        own = state.pixels[i]
        mismatch = Mismatch(
            np.float64(own.theta_on),
            np.float64(own.theta_off),
            np.float64(own.hot_rate),
            own.dark_factor * model.dark_lux,
            np.float64(own.leak_factor),
        )
        level = log_current(state.luminance[i] * model.lux_per_cd_m2, mismatch.dark_lux)
        segment = make_segment(model, mismatch, level, level, 1.0)
        pixel = stored_pixel(own, np.int64(own.draws))
        _, sleep_us, _ = advance_noisy(pixel, segment, mismatch, model, i, 0.0, True, False)
        wake_us[i] = np.int32(sleep_us)
    for block in range(state.block_wake_us.size):
        earliest_us = wake_us[block * BLOCK]
        for i in range(block * BLOCK, min((block + 1) * BLOCK, wake_us.size)):
            earliest_us = min(earliest_us, wake_us[i])
        state.block_wake_us[block] = earliest_us
