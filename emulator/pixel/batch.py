"""Follows many pixels at once through a segment without an event, which is the common case.

Active pixels are gathered into batches and followed to the end of the step by the equations of
`emulator.pixel.single_pixel`. Pixels that stay silent are then stored; the others are processed
further, most of them one by one. A batch is a flat array, field after field, so that the compiler
sees that the fields do not overlap, and works on several pixels at a time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator.noise.leak import leak_drift
from emulator.pixel import fields as at
from emulator.pixel.fields import BATCH, FIELDS, STRIDE
from emulator.pixel.photoreceptor import LOG_PIECE, inverse_tau_per_us, lag_after, log_current
from emulator.pixel.state import PixelModel, PixelState
from flybench.kernels import compiled, inlined
from flybench.portable_math import exp, log

_VECTOR = 8
"""Pixels that the compiler may process together."""

OTHER, CROSSING, SILENT, SINGLE = 0.0, 1.0, 2.0, 3.0
"""Outcome of the step for a pixel. CROSSING: at least one crossing, not computed yet; SILENT: no
event; SINGLE: exactly one event, which has been computed; OTHER: the batch cannot compute it."""

Reals = npt.NDArray[np.float64]


class Batch(NamedTuple):
    """Pixels that are processed together.

    Attributes:
        indices: (BATCH,) indices of the pixels on the sensor.
        changed: (BATCH,) True where the luminance has changed.
        fields: (FIELDS·BATCH,) numbers of the pixels, field after field.
        crossing: (BATCH,) positions in the batch of the pixels that cross a threshold.
        crossing_fields: (FIELDS·BATCH,) numbers of those pixels.
    """

    indices: npt.NDArray[np.int64]
    changed: npt.NDArray[np.bool_]
    fields: Reals
    crossing: npt.NDArray[np.int32]
    crossing_fields: Reals


def empty_batch() -> Batch:
    """Return an empty batch."""
    return Batch(
        np.empty(BATCH, np.int64),
        np.empty(BATCH, np.bool_),
        np.ones(FIELDS * STRIDE),
        np.empty(BATCH, np.int32),
        np.ones(FIELDS * STRIDE),
    )


@compiled
def gather(
    state: PixelState,
    model: PixelModel,
    luminance: npt.NDArray[np.float32],
    from_us: int,
    batch: Batch,
    count: int,
) -> None:
    """Copy the numbers of the first `count` pixels of a batch into its fields.

    Args:
        state: state of all pixels.
        model: constants of the sensor.
        luminance: (pixels,) luminance at the end of the step [cd/m²].
        from_us: start of the step [µs from the first sample].
        batch: indices of the pixels; the fields are changed in place.
        count: number of pixels.
    """
    pixels, before, dark_lux = state.pixels, state.luminance, model.dark_lux
    indices, fields = batch.indices, batch.fields
    for k in range(count):
        i = indices[k]
        pixel = pixels[i]
        fields[at.LUMINANCE_FROM + k] = before[i]
        fields[at.LUMINANCE_TO + k] = luminance[i]
        fields[at.LAG + k] = pixel.lag
        fields[at.CHANGE + k] = pixel.change
        fields[at.LEAK + k] = pixel.leak
        fields[at.CLOCK + k] = pixel.clock
        fields[at.THETA_ON + k] = pixel.theta_on
        fields[at.THETA_OFF + k] = pixel.theta_off
        fields[at.HOT_RATE + k] = pixel.hot_rate
        fields[at.DARK_LUX + k] = pixel.dark_factor * dark_lux
        fields[at.LEAK_FACTOR + k] = pixel.leak_factor
        fields[at.SECOND_LAG + k] = pixel.second_lag
        fields[at.REST + k] = np.int32(pixel.updated_us - from_us)
        fields[at.START + k] = 0.0


@inlined
def rounded_up(count: int) -> int:
    """Round a number of pixels up to a multiple of the pixels that are processed together.

    The positions beyond `count` hold numbers of earlier batches; their results are not used.
    """
    return (count + _VECTOR - 1) // _VECTOR * _VECTOR


@inlined
def turning_value(level: float, steady: float, swing: float, decay: float) -> tuple[float, float]:
    """Return the value of d(s) where it turns, or d(0) if it does not turn; and −s/τ there.

    It turns where exp(−s/τ) = −steady/swing, if that happens within the span (see
    `emulator.pixel.change_detector`).

    Args:
        level: d(0).
        steady: steady slope of d times τ.
        swing: amplitude of the exponential part of d.
        decay: exp(−span/τ).
    """
    ratio = -steady / swing
    turned = ratio if (ratio > decay) & (ratio < 1.0) else 1.0
    power = log(turned)
    return level - steady * power + swing * (1.0 - turned), power


@compiled
def follow_batch(fields: Reals, model: PixelModel, count: int, span_us: float) -> None:
    """Follow the first `count` pixels through `span_us`, as if none had an event.

    This is the result for pixels whose difference is between the thresholds at the end and where it
    turns. It requires that the pixel is awake and not in reset, on a ramp of one piece, without an
    event of a hot pixel in the step, and that the sensor has neither follower nor noise.
    """
    per_us = 1.0 / span_us
    per_cd_m2 = model.lux_per_cd_m2
    for k in range(count):
        lag, leak, dark_lux = fields[at.LAG + k], fields[at.LEAK + k], fields[at.DARK_LUX + k]
        log_from = log_current(fields[at.LUMINANCE_FROM + k] * per_cd_m2, dark_lux)
        log_to = log_current(fields[at.LUMINANCE_TO + k] * per_cd_m2, dark_lux)
        middle = 0.5 * (log_from + log_to)
        current_lux = exp(middle)
        corner = inverse_tau_per_us(current_lux, model.corner_per_lux, model.corner_limit)
        decay = exp(-span_us * corner)
        tau_us = 1.0 / corner
        drift = leak_drift(model.leak, current_lux - dark_lux, fields[at.LEAK_FACTOR + k])
        rise = log_to - log_from
        slope = rise * per_us
        new_lag = lag_after(lag, slope, tau_us, decay)
        new_change = fields[at.CHANGE + k] + rise - (new_lag - lag)
        new_leak = leak + drift * span_us
        new_clock = fields[at.CLOCK + k] - abs(fields[at.HOT_RATE + k]) * span_us
        level = fields[at.CHANGE + k] + leak
        end = new_change + new_leak
        turn, _ = turning_value(level, (slope + drift) * tau_us, lag - slope * tau_us, decay)
        within = (max(end, turn) < fields[at.THETA_ON + k]) & (
            min(end, turn) > -fields[at.THETA_OFF + k]
        )
        ready = (fields[at.REST + k] == 0.0) & (leak >= 0.0) & (new_clock > 0.0)
        bright = (log_from >= model.log_limit) & (log_to >= model.log_limit)
        short = (rise < LOG_PIECE) & (rise > -LOG_PIECE)
        plain = ready & (bright | short)
        fields[at.LOG_FROM + k] = log_from
        fields[at.LOG_TO + k] = log_to
        fields[at.NEW_LAG + k] = new_lag
        fields[at.NEW_CHANGE + k] = new_change
        fields[at.NEW_LEAK + k] = new_leak
        fields[at.NEW_SECOND_LAG + k] = 0.0
        fields[at.NEW_CLOCK + k] = new_clock
        fields[at.DRIFT + k] = drift
        fields[at.CORNER + k] = corner
        fields[at.END + k] = end
        fields[at.OUTCOME + k] = (SILENT if within else CROSSING) if plain else OTHER
