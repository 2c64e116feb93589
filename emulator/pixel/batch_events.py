"""The last pass over a batch: store the pixels that are finished, and step the others one by one.

The step of a single pixel is cut into segments on which everything is known in closed form. On each
segment, threshold crossings and noise compete; whichever comes first resets the pixel.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from emulator.pixel import fields as at
from emulator.pixel.batch import SILENT, SINGLE, Batch, Reals
from emulator.pixel.pixel_step import plan_step, segment_of
from emulator.pixel.segment import Mismatch, Pixel
from emulator.pixel.single_pixel import NO_EVENT, advance, silent_time_us
from emulator.pixel.state import DRAWS, MOVED, PixelModel, PixelState, StepTimes
from emulator.readout.event_keys import Keys, make_key
from flybench.kernels import compiled, inlined


@inlined
def mismatch_of(fields: Reals, k: int) -> Mismatch:
    """Return what differs from pixel to pixel, for the pixel at position `k` of a batch."""
    return Mismatch(
        fields[at.THETA_ON + k],
        fields[at.THETA_OFF + k],
        fields[at.HOT_RATE + k],
        fields[at.DARK_LUX + k],
        fields[at.LEAK_FACTOR + k],
    )


@inlined
def stored_pixel(own: Any, draws: np.int64) -> Pixel:
    """Return the state of a pixel from its record, an element of `PixelState.pixels`."""
    leak = np.float64(own.leak)
    return Pixel(
        np.float64(own.lag),
        np.float64(own.change),
        max(leak, 0.0),
        np.float64(own.clock),
        max(-leak, 0.0),
        draws,
        np.float64(own.second_lag),
    )


@inlined
def wake_time_us(
    pixel: Pixel, mismatch: Mismatch, drift: float, changed: bool, to_us: int
) -> np.int32:
    """Return the earliest time of the next event; the end of the step if the luminance changes.

    The arguments are scalars and not the batch: an array would be reference counted for each pixel.
    """
    sleep_us = 0.0
    if not changed:
        sleep_us = silent_time_us(pixel, mismatch, drift)
    return np.int32(to_us + np.int64(sleep_us))


@compiled
def store_finished(
    state: PixelState,
    luminance: npt.NDArray[np.float32],
    times: StepTimes,
    batch: Batch,
    count: int,
    noisy: bool,
    keys: Keys,
    used: int,
) -> int:
    """Store the pixels of a batch that are silent or have a single event.

    Args:
        state: state of all pixels; changed in place.
        luminance: (pixels,) luminance at the end of the step [cd/m²].
        times: start and end of the step.
        batch: the pixels.
        count: number of pixels.
        noisy: True if the pixels have noise.
        keys: output array for the keys of the events, with room for `count` more.
        used: number of entries of `keys` in use.

    Returns:
        Number of entries of `keys` then in use.
    """
    before, wake_us, pixels = state.luminance, state.wake_us, state.pixels
    indices, changes, fields = batch.indices, batch.changed, batch.fields
    moved = MOVED if noisy else np.uint32(0)
    drawn = DRAWS if noisy else np.uint32(0)
    step_us, now_us = times.to_us - times.from_us, np.int32(times.to_us)
    for k in range(count):
        outcome = fields[at.OUTCOME + k]
        if outcome < SILENT:
            continue
        i = int(indices[k])
        if outcome == SINGLE:
            keys[used] = make_key(fields[at.EVENT_TIME + k], step_us, i, int(fields[at.MARK + k]))
            used += 1
            pixels[i].draws += drawn
        lag, change = fields[at.NEW_LAG + k], fields[at.NEW_CHANGE + k]
        leak, clock = fields[at.NEW_LEAK + k], fields[at.NEW_CLOCK + k]
        second_lag = fields[at.NEW_SECOND_LAG + k]
        own = pixels[i]
        own.lag = lag
        own.change = change
        own.leak = leak
        own.clock = clock
        own.draws |= moved
        own.updated_us = now_us
        own.second_lag = second_lag
        before[i] = luminance[i]
        pixel = Pixel(lag, change, leak, clock, 0.0, np.int64(0), second_lag)
        mismatch = mismatch_of(fields, k)
        wake_us[i] = wake_time_us(pixel, mismatch, fields[at.DRIFT + k], changes[k], times.to_us)
    return used


@compiled
def step_others(
    state: PixelState,
    model: PixelModel,
    luminance: npt.NDArray[np.float32],
    times: StepTimes,
    batch: Batch,
    first: int,
    count: int,
    keys: Keys,
    used: int,
) -> tuple[int, int]:
    """Take the other pixels of a batch through the step, one by one, while `keys` has room.

    Args:
        state: state of all pixels; changed in place.
        model: constants of the sensor.
        luminance: (pixels,) luminance at the end of the step [cd/m²].
        times: start and end of the step.
        batch: the pixels.
        first: position in the batch at which to begin.
        count: number of pixels.
        keys: output array for the keys of the events.
        used: number of entries of `keys` in use.

    Returns:
        The position of the first pixel whose events found no room, or `count`; and the number of
        entries of `keys` then in use. That pixel is unchanged.
    """
    step_us = times.to_us - times.from_us
    span_us = np.float64(step_us)
    before, wake_us, pixels = state.luminance, state.wake_us, state.pixels
    indices, changes, fields = batch.indices, batch.changed, batch.fields
    for k in range(first, count):
        if fields[at.OUTCOME + k] >= SILENT:
            continue
        i = int(indices[k])
        own, changed = pixels[i], changes[k]
        pixel = stored_pixel(own, np.int64(own.draws))
        mismatch = mismatch_of(fields, k)
        log_from, log_to = fields[at.LOG_FROM + k], fields[at.LOG_TO + k]
        plan = plan_step(model, log_from, log_to, changed, -fields[at.REST + k], span_us)
        found = used
        for number in range(-1 if plan.constant_us > 0.0 else 0, plan.pieces):
            segment, start_us, segment_us = segment_of(model, mismatch, plan, number)
            elapsed_us = 0.0
            while elapsed_us < segment_us:
                pixel, spent_us, event_us, mark = advance(
                    pixel, segment, mismatch, model, i, segment_us - elapsed_us
                )
                if mark != NO_EVENT:
                    if found == keys.size:
                        return k, used
                    keys[found] = make_key(start_us + elapsed_us + event_us, step_us, i, mark)
                    found += 1
                elapsed_us += spent_us
        used = found
        own.lag = pixel.lag
        own.change = pixel.change
        own.leak = -pixel.reset_us if pixel.reset_us > 0.0 else pixel.leak
        own.clock = pixel.clock
        own.draws = pixel.draws
        own.updated_us = np.int32(times.to_us)
        own.second_lag = pixel.second_lag
        before[i] = luminance[i]
        wake_us[i] = wake_time_us(pixel, mismatch, fields[at.DRIFT + k], changed, times.to_us)
    return count, used
