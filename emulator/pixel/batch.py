"""Many pixels at once on one straight stretch without an event: the common case.

Pixels with work are gathered into batches, followed to the end of the step by the same equations
as one pixel is in `emulator.pixel.single_pixel`, and sorted into those that stayed silent, which
are put back, and the others, which go their way one by one. A batch is a flat array, field after
field, so that a compiler sees the fields don't overlap and works on several pixels at a time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator.pixel.noise import leak_drift, shot_rates
from emulator.pixel.photoreceptor import LOG_PIECE, corner_per_us, lag_after, log_current
from emulator.pixel.state import PixelModel, Pixels
from flybench.kernels import compiled, inlined
from flybench.portable_math import exp, log

BATCH = 512
"""Pixels in a batch: its 23 fields take 94 kB, which the nearest caches hold."""

(
    LIGHT_FROM,
    LIGHT_TO,
    LOG_FROM,
    LAG,
    CHANGE,
    LEAK,
    CLOCK,
    THETA_ON,
    THETA_OFF,
    HOT_RATE,
    REST,
    LOG_TO,
    NEW_LAG,
    NEW_CHANGE,
    NEW_LEAK,
    NEW_CLOCK,
    NOISE_RATE,
    DRIFT,
    CORNER,
    END,
    OUTCOME,
    EVENT_TIME,
    MARK,
) = (field * BATCH for field in range(23))
"""Where each field begins."""

FIELDS = 23

_TOGETHER = 16
"""Pixels that a compiler may work on together."""

COMPLEX, CROSSING, SILENT, SINGLE = 0.0, 1.0, 2.0, 3.0
"""What becomes of a pixel in the step: something that asks for a closer look; at least one
crossing, which must be found; no event; or one event, which has been found."""

Reals = npt.NDArray[np.float64]


class Batch(NamedTuple):
    """Pixels that are worked on together.

    Attributes:
        places: (BATCH,) their places in the array.
        changed: (BATCH,) whether their light has changed.
        fields: (FIELDS·BATCH,) their numbers, field after field.
        crossers: (BATCH,) places in the batch of those that cross a threshold.
        crossing: (FIELDS·BATCH,) numbers of those.
    """

    places: npt.NDArray[np.int32]
    changed: npt.NDArray[np.bool_]
    fields: Reals
    crossers: npt.NDArray[np.int32]
    crossing: Reals


def empty_batch() -> Batch:
    """Room for one batch."""
    return Batch(
        np.empty(BATCH, np.int32),
        np.empty(BATCH, np.bool_),
        np.ones(FIELDS * BATCH),
        np.empty(BATCH, np.int32),
        np.ones(FIELDS * BATCH),
    )


@compiled
def gather(
    pixels: Pixels,
    before: npt.NDArray[np.float32],
    after: npt.NDArray[np.float32],
    from_us: int,
    places: npt.NDArray[np.int32],
    count: int,
    fields: Reals,
) -> None:
    """Fetch the numbers of the first `count` pixels of a batch.

    Args:
        pixels: what they remember, and are.
        before: (pixels,) light at the start of the step [cd/m²].
        after: (pixels,) light at its end [cd/m²].
        from_us: start of the step [µs from the first sample].
        places: where the pixels of the batch are in the arrays.
        count: how many there are.
        fields: of the batch; put out.
    """
    for k in range(count):
        i = places[k]
        pixel = pixels[i]
        fields[LIGHT_FROM + k] = before[i]
        fields[LIGHT_TO + k] = after[i]
        fields[LAG + k] = pixel.lag
        fields[CHANGE + k] = pixel.change
        fields[LEAK + k] = pixel.leak
        fields[CLOCK + k] = pixel.clock
        fields[THETA_ON + k] = pixel.theta_on
        fields[THETA_OFF + k] = pixel.theta_off
        fields[HOT_RATE + k] = pixel.hot_rate
        fields[REST + k] = np.int32(pixel.touched_us - from_us)


@inlined
def rounded_up(count: int) -> int:
    """How many pixels to work on, so that none is left over from the groups that go together.

    What stands in the places beyond `count` is left from other batches, and not used.
    """
    return (count + _TOGETHER - 1) // _TOGETHER * _TOGETHER


@inlined
def turning_value(level: float, steady: float, swing: float, decay: float) -> tuple[float, float]:
    """Value of d(s) where it turns, or d(0) if it does not; and −s/τ there.

    It turns where exp(−s/τ) = −steady/swing, if that is reached in the time (see
    `emulator.pixel.change_detector`).

    Args:
        level: d(0).
        steady: steady slope of d times τ.
        swing: amplitude of the exponential part of d.
        decay: exp(−span/τ).
    """
    share = -steady / swing
    turned = share if (share > decay) & (share < 1.0) else 1.0
    power = log(turned)
    return level - steady * power + swing * (1.0 - turned), power


@compiled
def follow_batch(fields: Reals, model: PixelModel, count: int, span_us: float) -> None:
    """Follow the first `count` pixels through `span_us`, as if none had an event.

    That is the outcome of those whose difference stays between the thresholds at the end and where
    it turns. Before, they must be awake, not in reset, on a ramp of one piece, with time left on
    their noise clock, and without a follower.
    """
    per_us = 1.0 / span_us
    first_order = model.follower_us == 0.0
    per_cd_m2, dark_lux = model.lux_per_cd_m2, model.dark_lux
    for k in range(count):
        lag, leak = fields[LAG + k], fields[LEAK + k]
        log_from = log_current(fields[LIGHT_FROM + k] * per_cd_m2, dark_lux)
        log_to = log_current(fields[LIGHT_TO + k] * per_cd_m2, dark_lux)
        middle = 0.5 * (log_from + log_to)
        current_lux = exp(middle)
        corner = corner_per_us(current_lux, model.corner_per_lux, model.corner_limit)
        decay = exp(-span_us * corner)
        tau_us = 1.0 / corner
        shot_on, shot_off = shot_rates(model.noise, middle)
        noise_rate = shot_on + shot_off + abs(fields[HOT_RATE + k])
        drift = leak_drift(model.noise, current_lux)
        rise = log_to - log_from
        slope = rise * per_us
        new_lag = lag_after(lag, slope, tau_us, decay)
        new_change = fields[CHANGE + k] + rise - (new_lag - lag)
        new_leak = leak + drift * span_us
        new_clock = fields[CLOCK + k] - noise_rate * span_us
        level = fields[CHANGE + k] + leak
        end = new_change + new_leak
        turn, _ = turning_value(level, (slope + drift) * tau_us, lag - slope * tau_us, decay)
        within = (max(end, turn) < fields[THETA_ON + k]) & (min(end, turn) > -fields[THETA_OFF + k])
        ready = (fields[REST + k] == 0.0) & (leak >= 0.0) & (new_clock > 0.0)
        bright = (log_from >= model.log_limit) & (log_to >= model.log_limit)
        short = (rise < LOG_PIECE) & (rise > -LOG_PIECE)
        plain = first_order & ready & (bright | short)
        fields[LOG_FROM + k] = log_from
        fields[LOG_TO + k] = log_to
        fields[NEW_LAG + k] = new_lag
        fields[NEW_CHANGE + k] = new_change
        fields[NEW_LEAK + k] = new_leak
        fields[NEW_CLOCK + k] = new_clock
        fields[NOISE_RATE + k] = noise_rate
        fields[DRIFT + k] = drift
        fields[CORNER + k] = corner
        fields[END + k] = end
        fields[OUTCOME + k] = (SILENT if within else CROSSING) if plain else COMPLEX
