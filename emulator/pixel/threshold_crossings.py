"""The threshold crossings of many pixels at once: the second pass over a batch.

Of the pixels that cross a threshold, nearly all do so once in a step of a millisecond. Their
crossings are computed together, with a fixed number of Newton steps that suffices for nearly all.
Then the pixels are held in reset and followed to the end of the step, as in
`emulator.pixel.single_pixel`. Pixels that have not converged, or that may cross again, are left to
that module.
"""

from __future__ import annotations

import numpy as np

from emulator.pixel.batch import (
    CHANGE,
    CLOCK,
    CORNER,
    CROSSING,
    DRIFT,
    END,
    EVENT_TIME,
    HOT_RATE,
    LAG,
    LEAK,
    LOG_FROM,
    LOG_TO,
    MARK,
    NEW_CHANGE,
    NEW_CLOCK,
    NEW_LAG,
    NEW_LEAK,
    OUTCOME,
    SINGLE,
    THETA_OFF,
    THETA_ON,
    Batch,
    Reals,
    rounded_up,
    turning_value,
)
from emulator.pixel.change_detector import is_close
from emulator.pixel.photoreceptor import lag_after
from emulator.pixel.single_pixel import crossing_code
from emulator.pixel.state import PixelModel
from flybench.kernels import compiled
from flybench.portable_math import exp

_NEWTON_STEPS = 4


@compiled
def gather_crossings(batch: Batch, count: int) -> int:
    """Copy the pixels that cross a threshold to `batch.crossing_fields`; return their number.

    Args:
        batch: the batch; `crossing` and `crossing_fields` are changed in place.
        count: number of pixels in the batch.
    """
    fields, crossing, own = batch.fields, batch.crossing, batch.crossing_fields
    found = 0
    for k in range(count):
        crossing[found] = k
        found += fields[OUTCOME + k] == CROSSING
    for m in range(found):
        k = int(crossing[m])
        own[LAG + m] = fields[LAG + k]
        own[CHANGE + m] = fields[CHANGE + k]
        own[LEAK + m] = fields[LEAK + k]
        own[CLOCK + m] = fields[CLOCK + k]
        own[THETA_ON + m] = fields[THETA_ON + k]
        own[THETA_OFF + m] = fields[THETA_OFF + k]
        own[LOG_FROM + m] = fields[LOG_FROM + k]
        own[LOG_TO + m] = fields[LOG_TO + k]
        own[HOT_RATE + m] = fields[HOT_RATE + k]
        own[DRIFT + m] = fields[DRIFT + k]
        own[CORNER + m] = fields[CORNER + k]
        own[END + m] = fields[END + k]
    return found


@compiled
def find_crossings(own: Reals, model: PixelModel, count: int, span_us: float) -> None:
    """Compute the crossing of each of the first `count` pixels that has exactly one."""
    per_us = 1.0 / span_us
    for k in range(count):
        theta_on, theta_off, drift = own[THETA_ON + k], own[THETA_OFF + k], own[DRIFT + k]
        lag, leak, corner, end = own[LAG + k], own[LEAK + k], own[CORNER + k], own[END + k]
        level = own[CHANGE + k] + leak
        slope = (own[LOG_TO + k] - own[LOG_FROM + k]) * per_us
        tau_us = 1.0 / corner
        rate = slope + drift
        swing = lag - slope * tau_us
        decay = exp(-span_us * corner)
        turn, power = turning_value(level, rate * tau_us, swing, decay)
        before = (turn >= theta_on) | (turn <= -theta_off)
        low = 0.0 if before else -power * tau_us
        high = -power * tau_us if before else span_us
        bottom = level if before else turn
        top = turn if before else end
        on = top >= theta_on
        theta = theta_on if on else -theta_off
        s = low + (high - low) * (theta - bottom) / (top - bottom)
        close = False
        for _ in range(_NEWTON_STEPS):
            bend = swing * exp(-s * corner)
            excess = level + rate * s + swing - bend - theta
            steep = rate + bend * corner
            move = excess / steep
            s = min(max(s - move, low), high)
            close = is_close(move, bend * corner * corner, steep, corner)
        begin_us = s + model.refractory_us
        rest_us = span_us - begin_us
        held_lag = lag_after(lag, slope, tau_us, exp(-begin_us * corner))
        decay = exp(-rest_us * corner)
        new_lag = lag_after(held_lag, slope, tau_us, decay)
        new_change = slope * rest_us - (new_lag - held_lag)
        new_leak = drift * rest_us
        end = new_change + new_leak
        turn, _ = turning_value(0.0, rate * tau_us, held_lag - slope * tau_us, decay)
        within = (max(end, turn) < theta_on) & (min(end, turn) > -theta_off)
        sure = close & (s > low) & (s < high) & (rest_us > 0.0) & within
        own[NEW_LAG + k] = new_lag
        own[NEW_CHANGE + k] = new_change
        own[NEW_LEAK + k] = new_leak
        clear_us = span_us - model.refractory_us
        own[NEW_CLOCK + k] = own[CLOCK + k] - abs(own[HOT_RATE + k]) * clear_us
        own[OUTCOME + k] = SINGLE if sure else CROSSING
        own[EVENT_TIME + k] = s
        leaked = leak + drift * s
        own[MARK + k] = crossing_code(leaked, theta_on, on)


@compiled
def return_crossings(batch: Batch, count: int) -> None:
    """Copy the results of the first `count` crossing pixels back to their batch."""
    fields, crossing, own = batch.fields, batch.crossing, batch.crossing_fields
    for m in range(count):
        k = np.int64(crossing[m])
        fields[OUTCOME + k] = own[OUTCOME + m]
        fields[EVENT_TIME + k] = own[EVENT_TIME + m]
        fields[MARK + k] = own[MARK + m]
        if own[OUTCOME + m] == SINGLE:
            fields[NEW_LAG + k] = own[NEW_LAG + m]
            fields[NEW_CHANGE + k] = own[NEW_CHANGE + m]
            fields[NEW_LEAK + k] = own[NEW_LEAK + m]
            fields[NEW_CLOCK + k] = own[NEW_CLOCK + m]


@compiled
def solve_crossings(batch: Batch, model: PixelModel, count: int, span_us: float) -> None:
    """Compute the crossings of the first `count` pixels of a batch that have exactly one."""
    found = gather_crossings(batch, count)
    find_crossings(batch.crossing_fields, model, rounded_up(found), span_us)
    return_crossings(batch, found)
