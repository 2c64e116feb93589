"""Both thresholds from a known modulation of the light.

While the light's logarithm climbs or falls at a steady rate, so does the photoreceptor's output,
and between two consecutive events of a pixel it has gone by one threshold exactly. What it was at
the events is known, since the light is; a constant lag cancels. Leak helps it along on the way up
and holds it back on the way down, by its drift times the interval.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real

import numpy as np
import numpy.typing as npt

from emulator.characterisation.bench import counts
from emulator.characterisation.experiments.background import hot_pixels
from emulator.characterisation.recording_size import check_size
from emulator.errors import FitError
from flybench.events import Events, check_events

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Thresholds:
    """Thresholds of the healthy pixels of an array.

    Attributes:
        theta_on: mean ON threshold [ln units], None where no pixel shows it.
        theta_off: mean OFF threshold, positive [ln units], likewise.
        mismatch_on: standard deviation of the ON threshold over pixels [ln units], likewise.
        mismatch_off: that of the OFF threshold [ln units], likewise.
    """

    theta_on: float | None
    theta_off: float | None
    mismatch_on: float | None
    mismatch_off: float | None


def fit_ramps(
    events: Events,
    *,
    width: int,
    height: int,
    t_us: npt.ArrayLike,
    log_light: npt.ArrayLike,
    leak_drift_per_s: float = 0.0,
) -> Thresholds:
    """Estimate both thresholds from slow ramps of light that the whole array sees.

    Assumes light well above the dark current (or its logarithm with the dark current included),
    ramps slow against the photoreceptor, and noise that is rarer than the signal: a pixel's
    threshold is the median over its pairs of events.

    Args:
        events: sorted by t.
        width: columns of the sensor [px].
        height: rows of the sensor [px].
        t_us: (n,) rising times of the corners of the modulation [µs].
        log_light: (n,) logarithm of the light there; straight in between [ln units].
        leak_drift_per_s: drift of the memorised value by leak [ln units/s]; 0 without leak.

    Returns:
        Means and standard deviations over the pixels; None where the light never went that way.

    Raises:
        EventError: the events are no sorted stream from such a sensor.
        FitError: a size that is none, corners that do not rise in time, are not finite, fewer than
            two or unlike in number, or a drift that is negative or not finite.
    """
    width, height = check_size(width, height)
    check_events(events, width=width, height=height)
    times, light = _corners(t_us, log_light)
    numeric = isinstance(leak_drift_per_s, Real) and not isinstance(leak_drift_per_s, bool)
    if not numeric or not 0.0 <= leak_drift_per_s < math.inf:
        raise FitError(
            f"leak_drift_per_s is {leak_drift_per_s!r}; allowed is a finite number from 0, in ln "
            "units per second; leave it out if there is no leak"
        )
    healthy = ~hot_pixels(counts(events, (height, width)))
    kept = events[healthy[events["y"], events["x"]]]
    ordered = kept[np.lexsort((kept["t"], kept["x"], kept["y"]))]
    pixel = ordered["y"].astype(np.int64) * width + ordered["x"]
    ramp = np.searchsorted(times, ordered["t"], side="left")
    pair = (np.diff(pixel) == 0) & (np.diff(ramp) == 0) & (ordered["p"][1:] == ordered["p"][:-1])
    gone = np.diff(np.interp(ordered["t"], times, light))
    gone += leak_drift_per_s * 1e-6 * np.diff(ordered["t"])
    on = ordered["p"][1:]
    slope = np.concatenate(([0.0], np.sign(np.diff(light)), [0.0]))[ramp[1:]]
    pair &= slope == np.where(on, 1.0, -1.0)
    up = _per_pixel(pixel[1:][pair & on], gone[pair & on])
    down = _per_pixel(pixel[1:][pair & ~on], -gone[pair & ~on])
    return Thresholds(_mean(up), _mean(down), _spread(up), _spread(down))


def _corners(t_us: npt.ArrayLike, log_light: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Times [µs] and light [ln units] of the corners, refused where they are no modulation."""
    try:
        times, light = np.asarray(t_us, np.float64), np.asarray(log_light, np.float64)
    except (TypeError, ValueError):
        raise FitError(
            "t_us or log_light holds something that is no number; allowed are one-dimensional "
            "arrays of numbers; give one of each for each corner"
        ) from None
    if times.ndim != 1 or times.shape != light.shape or times.size < 2:
        raise FitError(
            f"t_us has shape {times.shape} and log_light {light.shape}; allowed is one dimension "
            "and the same length, from 2; give the light at each corner"
        )
    if not (np.isfinite(times).all() and np.isfinite(light).all()):
        raise FitError(
            "t_us or log_light holds NaN or infinity; allowed are finite numbers; give the "
            "logarithm of a light above darkness"
        )
    steps = np.diff(times)
    if not (steps > 0.0).all():
        bad = int(np.argmin(steps > 0.0)) + 1
        raise FitError(
            f"corner {bad} is at {times[bad]:g} µs after one at {times[bad - 1]:g} µs; allowed are "
            "times that rise; sort the corners by time, each once"
        )
    return times, light


def _per_pixel(pixel: npt.NDArray[np.int64], step: Floats) -> Floats:
    """Median step of each pixel that has one."""
    order = np.argsort(pixel, kind="stable")
    _, first = np.unique(pixel[order], return_index=True)
    return np.array([np.median(part) for part in np.split(step[order], first[1:]) if part.size])


def _mean(values: Floats) -> float | None:
    return float(values.mean()) if values.size else None


def _spread(values: Floats) -> float | None:
    return float(values.std()) if values.size else None
