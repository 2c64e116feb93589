"""The threshold crossings of many pixels at once: the second pass over a batch.

Of the pixels that cross a threshold, nearly all do so once in a step of a millisecond. Their
crossings are computed together, with a fixed number of Newton steps that suffices for nearly all.
Then the pixels are held in reset and followed to the end of the step, as in
`emulator.pixel.single_pixel`. Pixels that have not converged, or that may cross again, are left to
that module.
"""

from __future__ import annotations

import numpy as np

from emulator.pixel import fields as at
from emulator.pixel.batch import CROSSING, SINGLE, Batch, Reals, rounded_up, turning_value
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
        found += fields[at.OUTCOME + k] == CROSSING
    for m in range(found):
        k = int(crossing[m])
        own[at.LAG + m] = fields[at.LAG + k]
        own[at.CHANGE + m] = fields[at.CHANGE + k]
        own[at.LEAK + m] = fields[at.LEAK + k]
        own[at.CLOCK + m] = fields[at.CLOCK + k]
        own[at.THETA_ON + m] = fields[at.THETA_ON + k]
        own[at.THETA_OFF + m] = fields[at.THETA_OFF + k]
        own[at.LOG_FROM + m] = fields[at.LOG_FROM + k]
        own[at.LOG_TO + m] = fields[at.LOG_TO + k]
        own[at.HOT_RATE + m] = fields[at.HOT_RATE + k]
        own[at.DRIFT + m] = fields[at.DRIFT + k]
        own[at.CORNER + m] = fields[at.CORNER + k]
        own[at.END + m] = fields[at.END + k]
    return found


@compiled
def find_crossings(own: Reals, model: PixelModel, count: int, span_us: float) -> None:
    """Compute the crossing of each of the first `count` pixels that has exactly one."""
    per_us = 1.0 / span_us
    for k in range(count):
        theta_on, theta_off, drift = own[at.THETA_ON + k], own[at.THETA_OFF + k], own[at.DRIFT + k]
        lag, leak, corner, end = (
            own[at.LAG + k],
            own[at.LEAK + k],
            own[at.CORNER + k],
            own[at.END + k],
        )
        level = own[at.CHANGE + k] + leak
        slope = (own[at.LOG_TO + k] - own[at.LOG_FROM + k]) * per_us
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
        own[at.NEW_LAG + k] = new_lag
        own[at.NEW_CHANGE + k] = new_change
        own[at.NEW_LEAK + k] = new_leak
        clear_us = span_us - model.refractory_us
        own[at.NEW_CLOCK + k] = own[at.CLOCK + k] - abs(own[at.HOT_RATE + k]) * clear_us
        own[at.OUTCOME + k] = SINGLE if sure else CROSSING
        own[at.EVENT_TIME + k] = s
        leaked = leak + drift * s
        own[at.MARK + k] = crossing_code(leaked, theta_on, on)


@compiled
def return_crossings(batch: Batch, count: int) -> None:
    """Copy the results of the first `count` crossing pixels back to their batch."""
    fields, crossing, own = batch.fields, batch.crossing, batch.crossing_fields
    for m in range(count):
        k = np.int64(crossing[m])
        fields[at.OUTCOME + k] = own[at.OUTCOME + m]
        fields[at.EVENT_TIME + k] = own[at.EVENT_TIME + m]
        fields[at.MARK + k] = own[at.MARK + m]
        if own[at.OUTCOME + m] == SINGLE:
            fields[at.NEW_LAG + k] = own[at.NEW_LAG + m]
            fields[at.NEW_CHANGE + k] = own[at.NEW_CHANGE + m]
            fields[at.NEW_LEAK + k] = own[at.NEW_LEAK + m]
            fields[at.NEW_CLOCK + k] = own[at.NEW_CLOCK + m]


@compiled
def solve_crossings(batch: Batch, model: PixelModel, count: int, span_us: float) -> None:
    """Compute the crossings of the first `count` pixels of a batch that have exactly one."""
    found = gather_crossings(batch, count)
    find_crossings(batch.crossing_fields, model, rounded_up(found), span_us)
    return_crossings(batch, found)
