"""Estimates the parameters of a sensor from a recording of a static scene.

An event resets a pixel to what it sees, noise included. On a static scene the steps up and down
therefore cancel, but for the drift of the leak. Over a long time each pixel obeys

    θ_on·R_on − θ_off·R_off = leak

with the rates R of its events and the leak in ln units per second, as long as the noise is slower
than the refractory period. Noise that carries a pixel across a threshold and decays before the end
of the refractory period is not memorised, and adds to both terms: the default sensor gives 12 %
more ON events than its leak at 30 lux on the chip, and 2 % more from 300 lux.

What can be estimated from one static recording:

- The rates of ON and OFF events, always.
- θ_off/θ_on and the mismatch of the thresholds relative to θ_on, where noise gives many OFF events:
  R_on/R_off is then nearly θ_off/θ_on, pixel by pixel. The leak, which adds to R_on, has to be
  small beside the noise or known, such as from a recording in bright light.
- The leak in ON events per second and its spread, where OFF events are rare: R_on is then the leak.
- The thresholds themselves: never. All rates are the same if thresholds, noise and leak are all
  multiplied by one factor. `emulator.characterisation.ramp_fit` estimates them from a known
  modulation.
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

_FEWEST_OFF = 40
"""Median number of OFF events of a pixel that tells the ratio of its thresholds: an unfinished step
at either end of the recording then changes it by 3 %."""
_NOISY_HZ = 1.0
"""Least median OFF rate beside which an unknown leak is neglected. A leak of 0.1 Hz would then make
the ratio of the thresholds 10 % too high [Hz]."""
_LEAST_OFF_PER_LEAK = 1.0
"""Least median OFF rate, over a leak that is known. The leak of a pixel differs from it."""
_RARE = 0.05
"""OFF events per ON event below which ON events are the leak. The leak is then wrong by 2 % if the
ratio of the thresholds is from 0.6 to 1.4."""
_FEWEST_ON = 5
"""Median number of ON events of a pixel that tells the leak and its spread."""
_HALF_CELL = 0.5
_QUARTILES = 1.349
"""Distance of the quartiles of a normal distribution, in standard deviations."""
_QUANTILES = (5.0, 50.0, 95.0)
_ONE_DEVIATION = 15.87
"""Share of a normal distribution more than one standard deviation below the mean [%]."""

Floats = npt.NDArray[np.float64]
Quantiles = tuple[float, float, float]


@dataclass(frozen=True)
class StaticFit:
    """What a static recording tells about a sensor.

    Attributes:
        on_hz: ON events of a pixel, mean over all pixels [Hz].
        off_hz: OFF events of a pixel, mean over all pixels [Hz].
        on_quantiles_hz: rate of ON events below which 5, 50 and 95 % of the pixels are [Hz].
        off_quantiles_hz: the same for OFF events [Hz].
        threshold_ratio: median of θ_off/θ_on; None where noise does not prevail.
        relative_mismatch: standard deviation of a threshold over the pixels, over the median ON
            threshold, the same for both thresholds; None where noise does not prevail.
        leak_hz: median leak, in ON events per second [Hz]; None where noise hides it or ON events
            are too few.
        leak_spread: standard deviation of ln(leak) over the pixels, from the median and the
            quantile one standard deviation below it, so that a tail of pixels with a high leak
            hardly counts. The mismatch of the thresholds is in it. None if the leak is None.
        hot_share: share of pixels that fire far more often than the others, see
            `emulator.characterisation.recordings.hot_pixels`.
    """

    on_hz: float
    off_hz: float
    on_quantiles_hz: Quantiles
    off_quantiles_hz: Quantiles
    threshold_ratio: float | None
    relative_mismatch: float | None
    leak_hz: float | None
    leak_spread: float | None
    hot_share: float


def fit_static(
    events: Events,
    *,
    width: int,
    height: int,
    end_us: int,
    leak_hz: float | None = None,
) -> StaticFit:
    """Estimate rates, and what they tell about thresholds or leak, from a static scene.

    Twenty leak periods (some minutes) of a thousand pixels in bright light give the leak; forty
    OFF events of a pixel in dim light give the ratio of the thresholds and their mismatch.

    Args:
        events: sorted by t, at one illuminance, from time 0.
        width: columns of the sensor [px].
        height: rows of the sensor [px].
        end_us: end of the recording on the clock of the events [µs].
        leak_hz: known leak of the median pixel, in ON events per second [Hz]; None: unknown.

    Returns:
        Rates, thresholds and leak.

    Raises:
        EventError: the events are not a sorted stream from such a sensor.
        FitError: a width or height is out of range, the end is not finite or is before the last
            event, or the leak is negative or not finite.
    """
    width, height = check_recording(events, width=width, height=height)
    _check_known(events, end_us, leak_hz)
    shape, seconds = (height, width), max(float(end_us), 1.0) * 1e-6
    halves = [_counts(part, shape) for part in _halves(events, end_us)]
    on, off = halves[0] + halves[1]
    leak = _leak(events[events["p"]], on, off, shape, seconds)
    ratio = _ratio(halves, seconds, leak_hz)
    return StaticFit(
        float(on.mean()) / seconds,
        float(off.mean()) / seconds,
        _quantiles(on / seconds),
        _quantiles(off / seconds),
        *ratio,
        *leak,
        float(hot_pixels(event_counts(events, shape)).mean()),
    )


def _check_known(events: Events, end_us: int, leak_hz: float | None) -> None:
    last_us = int(events["t"][-1]) if events.size else 0
    numeric = isinstance(end_us, Real) and not isinstance(end_us, bool)
    if not numeric or not last_us <= end_us < math.inf:
        raise FitError(
            f"end_us is {end_us!r}. Allowed is a finite number from {last_us}, the time of the "
            "last event. Give the end of the recording on the clock of the events."
        )
    if leak_hz is None:
        return
    numeric = isinstance(leak_hz, Real) and not isinstance(leak_hz, bool)
    if not numeric or not 0.0 <= leak_hz < math.inf:
        raise FitError(
            f"leak_hz is {leak_hz!r}. Allowed is a finite number from 0 ON events per second. Pass "
            "None if it is unknown."
        )


def _halves(events: Events, end_us: int) -> tuple[Events, Events]:
    middle = int(np.searchsorted(events["t"], 0.5 * end_us))
    return events[:middle], events[middle:]


def _counts(events: Events, shape: tuple[int, int]) -> Floats:
    """Count the ON and OFF events of each pixel, (2, pixels)."""
    parts = (events[events["p"]], events[~events["p"]])
    return np.array([event_counts(part, shape).ravel() for part in parts], np.float64)


def _quantiles(rates: Floats) -> Quantiles:
    low, median, high = np.percentile(rates, _QUANTILES).tolist()
    return low, median, high


def _ratio(
    halves: list[Floats], seconds: float, leak_hz: float | None
) -> tuple[float | None, float | None]:
    """Return θ_off/θ_on and the relative mismatch; None if noise does not prevail.

    What the logarithms of both halves of the recording have in common is the mismatch; what
    differs between them is chance.
    """
    off_hz = float(np.median(halves[0][1] + halves[1][1])) / seconds
    least_hz = _NOISY_HZ if leak_hz is None else _LEAST_OFF_PER_LEAK * leak_hz
    if off_hz < max(least_hz, _FEWEST_OFF / seconds):
        return None, None
    leak = 0.5 * seconds * (leak_hz or 0.0)
    logs = np.array(
        [
            np.log(np.maximum(on - leak, _HALF_CELL) / np.maximum(off, _HALF_CELL))
            for on, off in halves
        ]
    )
    ratio = math.exp(float(np.median(logs.mean(axis=0))))
    total, difference = (_deviation(x) ** 2 for x in (logs.mean(axis=0), 0.5 * (logs[0] - logs[1])))
    scatter = math.sqrt(max(total - difference, 0.0))
    return ratio, scatter / math.hypot(1.0, 1.0 / ratio)


def _deviation(values: Floats) -> float:
    """Return the standard deviation, from the quartiles."""
    low, high = np.percentile(values, [25.0, 75.0])
    return float(high - low) / _QUARTILES


def _leak(
    on_events: Events, on: Floats, off: Floats, shape: tuple[int, int], seconds: float
) -> tuple[float | None, float | None]:
    """Return median leak [Hz] and spread; None if noise hides the leak or events are too few.

    The rate of a pixel is that between its first and last ON event, since the leak is regular and
    the recording starts and ends at any phase of it. Its OFF events count as if the thresholds were
    equal.
    """
    if np.median(on) < _FEWEST_ON or off.sum() > _RARE * on.sum():
        return None, None
    first, last = np.full(on.size, np.inf), np.full(on.size, -np.inf)
    pixel = on_events["y"].astype(np.int64) * shape[1] + on_events["x"]
    np.minimum.at(first, pixel, on_events["t"])
    np.maximum.at(last, pixel, on_events["t"])
    several = on > 1
    rate = on / seconds
    span_s = np.maximum(last - first, 1.0)[several] * 1e-6
    rate[several] = (on[several] - 1.0) / span_s
    net = rate * np.maximum(1.0 - off / np.maximum(on, 1.0), 0.0)
    low, median = np.percentile(net, [_ONE_DEVIATION, 50.0]).tolist()
    return median, math.log(median / low) if low > 0.0 else None
