"""Out of the batch again: silent pixels are put back, the others go their way one by one.

The way of a pixel through a step is cut into stretches on which everything is in closed form; on
each, threshold crossings and noise compete, and the first one resets the pixel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator.pixel.batch import (
    CHANGE,
    CLOCK,
    DRIFT,
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
    NOISE_RATE,
    OUTCOME,
    REST,
    SILENT,
    SINGLE,
    THETA_OFF,
    THETA_ON,
    Batch,
)
from emulator.pixel.photoreceptor import ramp_pieces
from emulator.pixel.single_pixel import (
    NO_EVENT,
    Pixel,
    Stretch,
    Threshold,
    earliest_event_us,
    follow_to_event,
    stretch_of,
)
from emulator.pixel.state import PixelModel, PixelState
from emulator.readout.event_keys import Keys, make_key
from flybench.kernels import compiled, inlined


class Way(NamedTuple):
    """Way of one pixel through a step.

    Attributes:
        rest_us: duration of the rest at constant light before the step, since a pixel may have
            slept through earlier ones; and of the step itself, if its light does not change [µs].
        rest_start_us: start of that rest, from the beginning of the step, at or before 0 [µs].
        log_from: u at the start [ln lux].
        log_to: u at the end [ln lux].
        piece_us: duration of each piece of the ramp that follows [µs].
        pieces: how many there are, 0 if the light does not change.
    """

    rest_us: float
    rest_start_us: float
    log_from: float
    log_to: float
    piece_us: float
    pieces: int


@inlined
def way_of(
    model: PixelModel,
    log_from: float,
    log_to: float,
    changed: bool,
    slept_us: float,
    span_us: float,
) -> Way:
    """Way of a pixel through a step of `span_us`, after it has slept for `slept_us`."""
    if not changed:
        return Way(slept_us + span_us, -slept_us, log_from, log_from, span_us, 0)
    pieces = ramp_pieces(log_from, log_to, model.log_limit)
    return Way(slept_us, -slept_us, log_from, log_to, span_us / pieces, pieces)


@inlined
def leg_of(
    model: PixelModel, threshold: Threshold, way: Way, leg: int
) -> tuple[Stretch, float, float]:
    """Leg of a way, with its start from the beginning of the step and its duration [µs].

    Leg −1 is the rest at constant light before, 0 to pieces − 1 are the ramp's.
    """
    if leg < 0:
        rest = stretch_of(model, threshold, way.log_from, way.log_from, way.rest_us)
        return rest, way.rest_start_us, way.rest_us
    rise = (way.log_to - way.log_from) / way.pieces
    low = way.log_from + leg * rise
    ramp = stretch_of(model, threshold, low, low + rise, way.piece_us)
    return ramp, leg * way.piece_us, way.piece_us


@inlined
def time_to_wake(
    pixel: Pixel,
    threshold: Threshold,
    noise_rate: float,
    drift: float,
    changed: bool,
    to_us: int,
) -> np.int32:
    """When a pixel may next have an event: at once, if its light is on the move.

    It takes numbers, not the batch: an array handed over for every pixel would be counted in and
    out of use for every pixel.
    """
    sleep_us = 0.0
    if not changed:
        sleep_us = earliest_event_us(pixel, threshold, noise_rate, drift)
    return np.int32(to_us + np.int64(sleep_us))


@compiled
def return_followed(
    state: PixelState,
    luminance: npt.NDArray[np.float32],
    step_us: int,
    to_us: int,
    batch: Batch,
    count: int,
    keys: Keys,
    used: int,
) -> int:
    """Put the pixels back that were followed through the step, and their events into `keys`.

    Args:
        state: of all pixels; changed in place.
        luminance: (pixels,) light at the end of the step [cd/m²].
        step_us: duration of the step [µs].
        to_us: its end [µs from the first sample].
        batch: the pixels.
        count: how many there are.
        keys: array to put the keys in, with room for `count` more.
        used: how many of `keys` are in use.

    Returns:
        How many of `keys` are in use then.
    """
    light, wake_us, pixels = state.luminance, state.wake_us, state.pixels
    places, changes, fields = batch.places, batch.changed, batch.fields
    now_us = np.int32(to_us)
    for k in range(count):
        outcome = fields[OUTCOME + k]
        if outcome < SILENT:
            continue
        i = int(places[k])
        if outcome == SINGLE:
            keys[used] = make_key(fields[EVENT_TIME + k], step_us, i, int(fields[MARK + k]))
            used += 1
        lag, change = fields[NEW_LAG + k], fields[NEW_CHANGE + k]
        leak, clock = fields[NEW_LEAK + k], fields[NEW_CLOCK + k]
        own = pixels[i]
        own.lag = lag
        own.change = change
        own.leak = leak
        own.clock = clock
        own.touched_us = now_us
        light[i] = luminance[i]
        pixel = Pixel(lag, change, leak, clock, 0.0, np.int64(0), 0.0)
        threshold = Threshold(fields[THETA_ON + k], fields[THETA_OFF + k], fields[HOT_RATE + k])
        wake_us[i] = time_to_wake(
            pixel, threshold, fields[NOISE_RATE + k], fields[DRIFT + k], changes[k], to_us
        )
    return used


@compiled
def finish_batch(
    state: PixelState,
    model: PixelModel,
    luminance: npt.NDArray[np.float32],
    from_us: int,
    to_us: int,
    batch: Batch,
    first: int,
    count: int,
    keys: Keys,
    used: int,
) -> tuple[int, int]:
    """Take those of a batch that ask for a closer look through a step, as far as `keys` holds out.

    Args:
        state: of all pixels; changed in place.
        model: constants of the sensor.
        luminance: (pixels,) light at the end of the step [cd/m²].
        from_us: start of the step [µs from the first sample].
        to_us: its end.
        batch: the pixels.
        first: which of them to begin with.
        count: how many there are.
        keys: array to put the events' keys in.
        used: how many of `keys` are in use.

    Returns:
        The first pixel of the batch whose events found no room, or `count`, and how many of `keys`
        are in use then. That pixel is as it was before the step.
    """
    step_us = to_us - from_us
    span_us = np.float64(step_us)
    light, wake_us, pixels = state.luminance, state.wake_us, state.pixels
    behind = state.behind
    places, changes, fields = batch.places, batch.changed, batch.fields
    for k in range(first, count):
        if fields[OUTCOME + k] >= SILENT:
            continue
        i = int(places[k])
        own, changed = pixels[i], changes[k]
        slow = behind[i] if behind.size > i else np.float32(0.0)
        leak = fields[LEAK + k]
        pixel = Pixel(
            fields[LAG + k],
            fields[CHANGE + k],
            max(leak, 0.0),
            fields[CLOCK + k],
            max(-leak, 0.0),
            np.int64(own.draws),
            np.float64(slow),
        )
        threshold = Threshold(fields[THETA_ON + k], fields[THETA_OFF + k], fields[HOT_RATE + k])
        log_from, log_to = fields[LOG_FROM + k], fields[LOG_TO + k]
        way = way_of(model, log_from, log_to, changed, -fields[REST + k], span_us)
        found = used
        for leg in range(-1 if way.rest_us > 0.0 else 0, way.pieces):
            stretch, start_us, leg_us = leg_of(model, threshold, way, leg)
            elapsed_us = 0.0
            while elapsed_us < leg_us:
                pixel, spent_us, event_us, mark = follow_to_event(
                    pixel, stretch, threshold, model, i, leg_us - elapsed_us
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
        own.leak = -pixel.busy_us if pixel.busy_us > 0.0 else pixel.leak
        own.clock = pixel.clock
        own.draws = pixel.draws
        own.touched_us = np.int32(to_us)
        if behind.size > i:
            behind[i] = pixel.behind
        light[i] = luminance[i]
        wake_us[i] = time_to_wake(
            pixel, threshold, fields[NOISE_RATE + k], fields[DRIFT + k], changed, to_us
        )
    return count, used
