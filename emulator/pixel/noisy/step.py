"""Takes the pixels with noise through a step one by one, where the batches do not suffice.

While the light of a pixel is constant, its pieces of time are counted from its last event, and its
state is stored only at the ends of pieces. The same events therefore come however the still light
is stepped. A pixel sleeps until its next event or the end of its piece.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from emulator.pixel import fields as at
from emulator.pixel.batch import SILENT, Batch
from emulator.pixel.batch_events import mismatch_of, stored_pixel
from emulator.pixel.noisy.advance import advance_noisy, as_stored, has_settled
from emulator.pixel.pixel_step import PixelStep, plan_step, segment_of
from emulator.pixel.segment import Mismatch, Pixel, make_segment
from emulator.pixel.single_pixel import NO_EVENT
from emulator.pixel.state import MOVED, PixelModel, PixelState, StepTimes
from emulator.readout.event_keys import Keys, make_key
from flybench.kernels import compiled


@compiled
def step_still(
    pixel: Pixel,
    mismatch: Mismatch,
    model: PixelModel,
    index: int,
    log_lux: float,
    rest_us: float,
    step_us: int,
    moved: bool,
    keys: Keys,
    used: int,
) -> tuple[Pixel, float, float, bool, int]:
    """Take a pixel in constant light from the time of its state through a step.

    Args:
        pixel: its state.
        mismatch: what differs from pixel to pixel.
        model: constants of the sensor.
        index: index of the pixel.
        log_lux: u [ln lux].
        rest_us: time of the state, from the start of the step [µs].
        step_us: duration of the step [µs].
        moved: True if a change of the light may contribute to the next event.
        keys: output array for the keys of the events.
        used: number of entries of `keys` in use.

    Returns:
        The state after the last piece that ends within the step; its time and the time to sleep
        until, both from the start of the step [µs]; `moved` for that state; and the number of
        entries of `keys` then in use, or −1 if there was no room.
    """
    segment = make_segment(model, mismatch, log_lux, log_lux, 1.0)
    at_us = rest_us
    while True:
        after, spent_us, mark = advance_noisy(
            pixel, segment, mismatch, model, index, 0.0, True, moved
        )
        if at_us + spent_us > step_us:
            return pixel, at_us, at_us + spent_us, moved, used
        at_us += spent_us
        pixel = as_stored(after)
        moved &= not has_settled(pixel, segment)
        if mark != NO_EVENT:
            if used == keys.size:
                return pixel, at_us, at_us, moved, -1
            keys[used] = make_key(at_us, step_us, index, mark)
            used += 1


@compiled
def step_moving(
    pixel: Pixel,
    mismatch: Mismatch,
    model: PixelModel,
    index: int,
    plan: PixelStep,
    step_us: int,
    keys: Keys,
    used: int,
) -> tuple[Pixel, int]:
    """Take a pixel whose light changes to the end of a step; see `step_still`."""
    for number in range(-1 if plan.constant_us > 0.0 else 0, plan.pieces):
        segment, start_us, segment_us = segment_of(model, mismatch, plan, number)
        elapsed_us = 0.0
        while elapsed_us < segment_us:
            pixel, spent_us, mark = advance_noisy(
                pixel, segment, mismatch, model, index, segment_us - elapsed_us, False, True
            )
            elapsed_us += spent_us
            if mark != NO_EVENT:
                if used == keys.size:
                    return pixel, -1
                keys[used] = make_key(start_us + elapsed_us, step_us, index, mark)
                used += 1
    return pixel, used


@compiled
def step_noisy(
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

    Arguments and result are those of `emulator.pixel.batch_events.step_others`.
    """
    step_us = times.to_us - times.from_us
    before, wake_us, pixels = state.luminance, state.wake_us, state.pixels
    indices, changes, fields = batch.indices, batch.changed, batch.fields
    for k in range(first, count):
        if fields[at.OUTCOME + k] >= SILENT:
            continue
        i = int(indices[k])
        own, changed = pixels[i], changes[k]
        rest_us = np.float64(np.int32(own.updated_us - times.from_us))
        pixel = stored_pixel(own, np.int64(own.draws & ~MOVED))
        mismatch = mismatch_of(fields, k)
        log_from, log_to = fields[at.LOG_FROM + k], fields[at.LOG_TO + k]
        stored_us = sleep_us = float(step_us)
        moved = changed or own.draws >= MOVED
        if changed:
            plan = plan_step(model, log_from, log_to, True, -rest_us, np.float64(step_us))
            pixel, found = step_moving(pixel, mismatch, model, i, plan, step_us, keys, used)
        else:
            pixel, stored_us, sleep_us, moved, found = step_still(
                pixel, mismatch, model, i, log_from, rest_us, step_us, moved, keys, used
            )
        if found < 0:
            return k, used
        used = found
        own.lag = pixel.lag
        own.change = pixel.change
        own.leak = -pixel.reset_us if pixel.reset_us > 0.0 else pixel.leak
        own.clock = pixel.clock
        own.draws = np.uint32(pixel.draws) | (MOVED if moved else np.uint32(0))
        own.updated_us = np.int32(times.from_us + np.int64(stored_us))
        own.second_lag = pixel.second_lag
        before[i] = luminance[i]
        wake_us[i] = np.int32(times.from_us + np.int64(sleep_us))
    return count, used
