"""All event pixels through one step of light, in one pass: the hot loop of the emulator.

A pixel is worked on only where its light has changed or where its next event is due; the others
cost two comparisons. Its way through the step is cut into stretches on which everything is in
closed form; on each, threshold crossings and noise compete, and the first one resets the pixel.

The functions below it pass one pixel's numbers by value, as tuples of scalars: the compiler keeps
those in registers, where arrays handed from function to function would cost a reference count each.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator._compile import compiled, inlined
from emulator.event_keys import Keys, make_key
from emulator.photoreceptor import log_current, ramp_pieces
from emulator.pixel import (
    NO_EVENT,
    Pixel,
    Stretch,
    Threshold,
    earliest_event_us,
    follow_to_event,
    stretch_of,
)
from emulator.pixels import FrozenMaps, PixelModel, PixelState


class Way(NamedTuple):
    """Way of one pixel through a step.

    Attributes:
        rest_start_us: start of the rest at constant light, from the beginning of the step; at or
            before 0, since a pixel may have slept through earlier steps [µs].
        rest_us: duration of that rest, 0 for none [µs].
        log_from: u at the start [ln lux].
        log_to: u at the end [ln lux].
        piece_us: duration of each piece of the ramp that follows [µs].
        pieces: how many there are, 0 if the light does not change.
    """

    rest_start_us: float
    rest_us: float
    log_from: float
    log_to: float
    piece_us: float
    pieces: int


@compiled
def load_pixel(state: PixelState, i: int) -> Pixel:
    """Numbers of pixel `i`, as double precision."""
    return Pixel(
        np.float64(state.lag[i]),
        np.float64(state.change[i]),
        np.float64(state.leak[i]),
        np.float64(state.clock[i]),
        np.float64(state.busy_us[i]),
        np.int64(state.draws[i]),
    )


@compiled
def store_pixel(state: PixelState, i: int, pixel: Pixel) -> None:
    """Put the numbers of pixel `i` back."""
    state.lag[i] = pixel.lag
    state.change[i] = pixel.change
    state.leak[i] = pixel.leak
    state.clock[i] = pixel.clock
    state.busy_us[i] = pixel.busy_us
    state.draws[i] = pixel.draws


@compiled
def load_threshold(maps: FrozenMaps, i: int) -> Threshold:
    """Mismatch of pixel `i`, as double precision."""
    return Threshold(
        np.float64(maps.theta_on[i]), np.float64(maps.theta_off[i]), np.float64(maps.hot_rate[i])
    )


@inlined
def way_of(
    model: PixelModel,
    log_from: float,
    luminance: float,
    changed: bool,
    touched_us: int,
    from_us: int,
    to_us: int,
) -> Way:
    """Way of a pixel that was last touched at `touched_us` through the step [from_us, to_us]."""
    rest_us = np.float64(touched_us - from_us)
    span_us = np.float64(to_us - from_us)
    if not changed:
        return Way(rest_us, span_us - rest_us, log_from, log_from, span_us, 0)
    log_to = log_current(luminance * model.lux_per_cd_m2, model.dark_lux)
    log_to = np.float64(np.float32(log_to))
    pieces = ramp_pieces(log_from, log_to, model.log_limit)
    return Way(rest_us, -rest_us, log_from, log_to, span_us / pieces, pieces)


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


@compiled
def step_pixels(
    state: PixelState,
    maps: FrozenMaps,
    model: PixelModel,
    luminance: npt.NDArray[np.float32],
    from_us: int,
    to_us: int,
    keys: Keys,
    first: int,
    count: int,
) -> tuple[int, int]:
    """Take the pixels from `first` on through one step of light, as far as `keys` holds out.

    Args:
        state: of all pixels; changed in place.
        maps: mismatch of all pixels.
        model: constants of the sensor.
        luminance: (pixels,) light at the end of the step [cd/m²].
        from_us: start of the step [µs from the first sample].
        to_us: its end.
        keys: array to put the events' keys in.
        first: pixel to begin with.
        count: how many of `keys` are in use.

    Returns:
        The first pixel whose events found no room, or the number of pixels, and how many of `keys`
        are in use then. That pixel is as it was before the step.
    """
    for i in range(first, luminance.size):
        changed = luminance[i] != state.luminance[i]
        if not changed and state.wake_us[i] > to_us:
            continue
        pixel, threshold = load_pixel(state, i), load_threshold(maps, i)
        log_from, light = np.float64(state.log_lux[i]), np.float64(luminance[i])
        way = way_of(model, log_from, light, changed, state.touched_us[i], from_us, to_us)
        used = count
        for leg in range(-1 if way.rest_us > 0.0 else 0, way.pieces):
            stretch, start_us, span_us = leg_of(model, threshold, way, leg)
            elapsed_us = 0.0
            while elapsed_us < span_us:
                pixel, wait_us, mark = follow_to_event(
                    pixel, stretch, threshold, model, i, span_us - elapsed_us
                )
                elapsed_us += wait_us
                if mark != NO_EVENT:
                    if used == keys.size:
                        return i, count
                    keys[used] = make_key(start_us + elapsed_us, to_us - from_us, i, mark)
                    used += 1
        count = used
        store_pixel(state, i, pixel)
        state.luminance[i], state.log_lux[i] = luminance[i], way.log_to
        state.touched_us[i] = state.wake_us[i] = to_us
        if not changed:
            rest = stretch_of(model, threshold, way.log_to, way.log_to, 1.0)
            state.wake_us[i] += int(earliest_event_us(pixel, rest, threshold))
    return luminance.size, count
