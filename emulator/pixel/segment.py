"""One event pixel in a segment of time without an event, or in reset.

The functions pass the numbers of one pixel by value, as tuples of scalars: the compiler keeps those
in registers, whereas an array handed from function to function would be reference counted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from emulator.noise.leak import leak_drift
from emulator.noise.photoreceptor_noise import Noise, noise_of
from emulator.pixel.photoreceptor import inverse_tau_per_us, lag_after
from emulator.pixel.source_follower import second_lag_after
from emulator.pixel.state import PixelModel
from flybench.kernels import inlined
from flybench.portable_math import exp


class Pixel(NamedTuple):
    """State of one pixel; see `emulator.pixel.state.PIXEL_DTYPE`.

    Attributes:
        reset_us: rest of the refractory period, 0 if the pixel is not held in reset [µs].
        second_lag: photoreceptor's output minus the follower's [ln units].
    """

    lag: float
    change: float
    leak: float
    clock: float
    reset_us: float
    draws: np.int64
    second_lag: float


class Mismatch(NamedTuple):
    """What differs from pixel to pixel; see `emulator.pixel.state.PIXEL_DTYPE`.

    Attributes:
        dark_lux: dark current [lux].
    """

    theta_on: float
    theta_off: float
    hot_rate: float
    dark_lux: float
    leak_factor: float


class Segment(NamedTuple):
    """An interval of time on which u changes linearly and all rates are constant.

    Attributes:
        slope: slope of u [ln units/µs].
        tau_us: time constant τ of the photoreceptor [µs].
        corner: 1/τ [1/µs].
        hot_rate: rate of a hot or crazy pixel, else 0 [events/µs].
        leak_drift: drift of the memorised value [ln units/µs].
        noise: noise of the photoreceptor.
    """

    slope: float
    tau_us: float
    corner: float
    hot_rate: float
    leak_drift: float
    noise: Noise


@inlined
def make_segment(
    model: PixelModel, mismatch: Mismatch, log_from: float, log_to: float, span_us: float
) -> Segment:
    """Return a segment of `span_us` on which u changes from `log_from` to `log_to`.

    All rates are those in the middle of the segment.
    """
    middle = 0.5 * (log_from + log_to)
    current_lux = exp(middle)
    corner = inverse_tau_per_us(current_lux, model.corner_per_lux, model.corner_limit)
    return Segment(
        (log_to - log_from) / span_us,
        1.0 / corner,
        corner,
        abs(mismatch.hot_rate),
        leak_drift(model.leak, current_lux - mismatch.dark_lux, mismatch.leak_factor),
        noise_of(model.sigma_0, corner, model.corner_per_lux * current_lux, model.follower_us),
    )


@inlined
def lags_after(
    pixel: Pixel, segment: Segment, model: PixelModel, span_us: float, decay: float
) -> tuple[float, float]:
    """Return the lags of photoreceptor and follower after `span_us`; `decay` is exp(−span/τ)."""
    lag = lag_after(pixel.lag, segment.slope, segment.tau_us, decay)
    if model.follower_us == 0.0:
        return lag, 0.0
    return lag, second_lag_after(
        pixel.lag, pixel.second_lag, segment.slope, segment.tau_us, model.follower_us, span_us
    )


@inlined
def without_event(
    pixel: Pixel, segment: Segment, model: PixelModel, span_us: float, decay: float
) -> Pixel:
    """Return the pixel after `span_us` without an event; `decay` is exp(−span/τ)."""
    lag, second_lag = lags_after(pixel, segment, model, span_us, decay)
    return Pixel(
        lag,
        pixel.change
        + segment.slope * span_us
        - (lag - pixel.lag)
        - (second_lag - pixel.second_lag),
        pixel.leak + segment.leak_drift * span_us,
        pixel.clock - segment.hot_rate * span_us,
        0.0,
        pixel.draws,
        second_lag,
    )


@inlined
def hold_in_reset(
    pixel: Pixel, segment: Segment, model: PixelModel, after_us: float, hold_us: float
) -> Pixel:
    """Return the pixel after `after_us` and then `hold_us` in reset, which stops its clock."""
    span_us = after_us + hold_us
    lag, second_lag = lags_after(pixel, segment, model, span_us, exp(-span_us * segment.corner))
    clock = pixel.clock - segment.hot_rate * after_us
    return Pixel(lag, 0.0, 0.0, clock, pixel.reset_us - hold_us, pixel.draws, second_lag)
