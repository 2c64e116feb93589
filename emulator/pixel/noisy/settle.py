"""Lets noisy pixels settle to a scene, so that a recording does not begin with a burst.

A pixel that has looked at the scene for a long time has fired and been reset at random. Its leak
phase and its noise cannot be drawn from a simple distribution. Each pixel is therefore taken
through still light before the first sample, as long as its events need to forget the start.
"""

from __future__ import annotations

import numpy as np

from emulator.pixel.noisy.advance import advance_noisy, as_stored
from emulator.pixel.photoreceptor import log_current
from emulator.pixel.segment import Mismatch, Pixel, Segment, make_segment
from emulator.pixel.single_pixel import NO_EVENT
from emulator.pixel.state import BLOCK, PixelModel, PixelState
from flybench.kernels import compiled

_SPANS_US = (0.2e6, 0.6e6, 2e6, 6e6, 20e6)
"""Times after which a pixel may have settled: the longest is that which the leak of the median
pixel needs from one event to the next (assumed to suffice)."""

_EVENTS = 16
"""Number of events by which a pixel must have fired to settle before the longest time (assumed)."""


@compiled
def run_still(
    pixel: Pixel, segment: Segment, mismatch: Mismatch, model: PixelModel, index: int
) -> tuple[Pixel, float, float]:
    """Take a pixel through still light until it has settled.

    Returns:
        The state after the last piece of time, and the time from there to the end of settling and
        from that to the end of the next piece [µs].
    """
    at_us, events = 0.0, 0
    for span_us in _SPANS_US:
        while True:
            after, spent_us, mark = advance_noisy(
                pixel, segment, mismatch, model, index, 0.0, True, False
            )
            if at_us + spent_us > span_us:
                break
            at_us += spent_us
            pixel = as_stored(after)
            events += mark != NO_EVENT
        rest_us, sleep_us = span_us - at_us, at_us + spent_us - span_us
        if events >= _EVENTS:
            break
    return pixel, rest_us, sleep_us


@compiled
def settle(state: PixelState, model: PixelModel) -> None:
    """Let all pixels settle to the luminance of the state, which is changed in place."""
    pixels, wake_us = state.pixels, state.wake_us
    for i in range(pixels.size):
        own = pixels[i]
        mismatch = Mismatch(
            np.float64(own.theta_on),
            np.float64(own.theta_off),
            np.float64(own.hot_rate),
            own.dark_factor * model.dark_lux,
            np.float64(own.leak_factor),
        )
        lux = state.luminance[i] * model.lux_per_cd_m2
        level = log_current(lux, mismatch.dark_lux)
        segment = make_segment(model, mismatch, level, level, 1.0)
        fresh = Pixel(
            0.0, 0.0, np.float64(own.leak), np.float64(own.clock), 0.0, np.int64(own.draws), 0.0
        )
        pixel, rest_us, sleep_us = run_still(fresh, segment, mismatch, model, i)
        own.lag = pixel.lag
        own.change = pixel.change
        own.leak = -pixel.reset_us if pixel.reset_us > 0.0 else pixel.leak
        own.clock = pixel.clock
        own.draws = pixel.draws
        own.updated_us = np.int32(-rest_us)
        wake_us[i] = np.int32(sleep_us)
        own.second_lag = pixel.second_lag
    for block in range(state.block_wake_us.size):
        first = block * BLOCK
        state.block_wake_us[block] = wake_us[first : first + BLOCK].min()
