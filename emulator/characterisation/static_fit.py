"""Estimates what a recording of a static scene shows: leak, or the ratio of the thresholds.

In bright light there is no noise. Leak moves the memorised value of each pixel to the ON threshold
again and again, at a rate that differs from pixel to pixel. The rate of the median pixel and the
spread of ln(rate) are those of the leak.

In dim light, noise crosses both thresholds. An event resets the pixel to what it sees, noise
included, so ON and OFF events have to cancel: θ_on·R_on − θ_off·R_off is the leak, whatever the
noise. The ratio of the rates is therefore that of the thresholds, also in each pixel, whose counts
show the mismatch. This holds while the noise is slower than the refractory period, as it is in dim
light; otherwise some of the noise at an event is gone when the pixel memorises.

A static recording tells no threshold in ln units: it takes light that changes in a known way
(`emulator.characterisation.ramp_fit`), or frames beside the events.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real

import numpy as np
import numpy.typing as npt

from emulator.characterisation.bench import event_counts
from emulator.characterisation.recordings import check_recording, hot_pixels
from emulator.errors import FitError
from flybench.events import Events

_RARE = 0.02
"""OFF rate, as a share of the ON rate, up to which the ON events are those of the leak."""
_FEWEST = 10
"""Fewest events of a pixel, or of a pixel and polarity, that count for a spread (assumed)."""
_FEWEST_PIXELS = 100
_LEAST_OFF = 200
"""Fewest OFF events of the array that give a ratio (assumed)."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class StaticFit:
    """What a static recording tells about the healthy pixels.

    Attributes:
        on_hz: mean rate of ON events of a pixel [Hz].
        off_hz: mean rate of OFF events of a pixel [Hz].
        leak_hz: leak of the median pixel [Hz]; None if noise adds to the events.
        leak_spread: standard deviation of ln(leak) over the pixels, without a tail; None if noise
            adds to the events, or if pixels have too few.
        theta_ratio: θ_off/θ_on; None if there are too few OFF events, or leak prevails.
        relative_mismatch: standard deviation of a threshold over the pixels, as a share of it; None
            with too few events of a pixel.
        hot_share: share of pixels left out as hot.
    """

    on_hz: float
    off_hz: float
    leak_hz: float | None
    leak_spread: float | None
    theta_ratio: float | None
    relative_mismatch: float | None
    hot_share: float


def fit_static(
    events: Events, *, width: int, height: int, end_us: int, leak_hz: float = 0.0
) -> StaticFit:
    """Estimate leak, or the ratio of the thresholds, from a recording of a static scene.

    Some minutes of a thousand pixels give every value within a few per cent. The docstring of the
    module lists the assumptions.

    Args:
        events: sorted by t, at one illuminance.
        width: columns of the sensor [px].
        height: rows of the sensor [px].
        end_us: end of the recording on the clock of the events [µs].
        leak_hz: mean leak of the pixels at that illuminance, which is subtracted from the ON rate
            before it is compared with the OFF rate [Hz].

    Raises:
        EventError: the events are not a sorted stream from such a sensor.
        FitError: a width or height is out of range, the end is not finite or is before the last
            event, or the leak is negative or not finite.
    """
    width, height = check_recording(events, width=width, height=height)
    _check_known(events, end_us, leak_hz)
    seconds = (end_us - (int(events["t"][0]) if events.size else 0)) * 1e-6
    shape = (height, width)
    healthy = ~hot_pixels(event_counts(events, shape))
    polarity = events["p"]
    on, off = (event_counts(events[polarity == p], shape)[healthy] for p in (True, False))
    if on.size == 0 or seconds <= 0.0:
        return StaticFit(0.0, 0.0, None, None, None, None, 1.0 - float(healthy.mean()))
    on_hz, off_hz = float(on.mean()) / seconds, float(off.mean()) / seconds
    leak = spread = ratio = mismatch = None
    if on.sum() > 0 and off_hz <= _RARE * on_hz:
        leak = _middle(on) / seconds
        spread = _spread(on)
    elif off.sum() >= _LEAST_OFF and on_hz > 2.0 * leak_hz:
        ratio = (on_hz - leak_hz) / off_hz
        mismatch = _mismatch(np.asarray(on - leak_hz * seconds, np.float64), off.astype(np.float64))
    return StaticFit(on_hz, off_hz, leak, spread, ratio, mismatch, 1.0 - float(healthy.mean()))


def _check_known(events: Events, end_us: int, leak_hz: float) -> None:
    last_us = int(events["t"][-1]) if events.size else 0
    if not _is_number(end_us) or not last_us <= end_us < math.inf:
        raise FitError(
            f"end_us is {end_us!r}. Allowed is a finite number from {last_us}, the time of the "
            "last event. Give the end of the recording on the clock of the events."
        )
    if not _is_number(leak_hz) or not 0.0 <= leak_hz < math.inf:
        raise FitError(
            f"leak_hz is {leak_hz!r}. Allowed is a finite number from 0 Hz. Leave it out if there "
            "is no leak."
        )


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _middle(counts: npt.NDArray[np.int64]) -> float:
    """Return the mean of the middle fifth: a median that is not rounded to whole events."""
    ordered = np.sort(counts)
    return float(ordered[int(0.4 * ordered.size) : int(0.6 * ordered.size) + 1].mean())


def _spread(counts: npt.NDArray[np.int64]) -> float | None:
    """Return the standard deviation of ln(count), from its quartiles."""
    if np.median(counts) < _FEWEST:
        return None
    low, high = np.percentile(np.log(np.maximum(counts, 0.5)), [25, 75])
    return float(high - low) / 1.349


def _mismatch(on: Floats, off: Floats) -> float | None:
    """Return the relative standard deviation of a threshold, from the ratio of each pixel's counts.

    The ratio contains both thresholds. Counts are off by up to one event, which adds variance.
    """
    enough = (on >= _FEWEST) & (off >= _FEWEST)
    if np.count_nonzero(enough) < _FEWEST_PIXELS:
        return None
    on, off = on[enough], off[enough]
    low, high = np.percentile(np.log(on / off), [25, 75])
    chance = float(np.median(1.0 / on**2 + 1.0 / off**2)) / 6.0
    return math.sqrt(max((float(high - low) / 1.349) ** 2 - chance, 0.0) / 2.0)
