"""Estimates both thresholds from a known modulation of the luminance.

While the logarithm of the luminance rises or falls at a constant rate, so does the output of the
photoreceptor. From the end of the refractory period after an event to the next event, it changes by
one threshold. The output is known, because the luminance is; a constant lag cancels. Leak adds its
drift times the interval on the way up, and subtracts it on the way down.

Noise helps to cross the threshold, and part of it is gone when the pixel memorises, so that the
change is smaller by up to some σ of the noise if the refractory period is longer than the
correlation time of the noise. Bright light and fast ramps, in which the crossing is sharp, keep
this small.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real

import numpy as np
import numpy.typing as npt

from emulator.characterisation.recordings import check_recording, healthy_events
from emulator.errors import FitError
from flybench.checks import Range
from flybench.events import Events

_REFRACTORY = Range(0, 1_000_000, "µs", "Give whole microseconds, such as 270.")

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Thresholds:
    """Thresholds of the healthy pixels of an array.

    Attributes:
        theta_on: mean ON threshold [ln units]; None if no pixel shows it.
        theta_off: mean OFF threshold, positive [ln units]; None if no pixel shows it.
        mismatch_on: standard deviation of the ON threshold over pixels [ln units]; None if no pixel
            shows it.
        mismatch_off: standard deviation of the OFF threshold over pixels [ln units]; None if no
            pixel shows it.
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
    log_luminance: npt.ArrayLike,
    leak_drift_per_s: float = 0.0,
    refractory_us: int = 0,
) -> Thresholds:
    """Estimate both thresholds from slow luminance ramps that the whole array sees.

    Three things are assumed. The luminance is well above the dark current, or its logarithm
    includes the dark current. The ramps are slow compared with the photoreceptor. Noise is rarer
    than the signal: a pixel's threshold is the median over its pairs of events.

    Args:
        events: sorted by t.
        width: columns of the sensor [px].
        height: rows of the sensor [px].
        t_us: (n,) rising times of the corners of the modulation [µs].
        log_luminance: (n,) logarithm of the luminance at the corners, linear in between [ln units].
        leak_drift_per_s: drift of the memorised value by leak [ln units/s]; 0 without leak.
        refractory_us: refractory period [µs].

    Returns:
        Means and standard deviations over the pixels; None for a direction without a ramp.

    Raises:
        EventError: the events are not a sorted stream from such a sensor.
        FitError: a width or height is out of range; the corners are fewer than two, not finite, not
            rising in time, or differ in number; the drift is negative or not finite; or the
            refractory period is not a whole number from 0 to 1000000.
    """
    width, height = check_recording(events, width=width, height=height)
    times, luminance = _corners(t_us, log_luminance)
    _check_drift(leak_drift_per_s)
    reset_us = _REFRACTORY.check("refractory_us", refractory_us, FitError)
    healthy = healthy_events(events, (height, width))
    ordered, pixel = healthy.events, healthy.pixel
    ramp = np.searchsorted(times, ordered["t"], side="left")
    pair = (np.diff(pixel) == 0) & (np.diff(ramp) == 0) & (ordered["p"][1:] == ordered["p"][:-1])
    t = ordered["t"]
    change = np.interp(t[1:], times, luminance) - np.interp(t[:-1] + reset_us, times, luminance)
    change += leak_drift_per_s * 1e-6 * (np.diff(t) - reset_us)
    on = ordered["p"][1:]
    slope = np.concatenate(([0.0], np.sign(np.diff(luminance)), [0.0]))[ramp[1:]]
    pair &= slope == np.where(on, 1.0, -1.0)
    up = _per_pixel(pixel[1:][pair & on], change[pair & on])
    down = _per_pixel(pixel[1:][pair & ~on], -change[pair & ~on])
    return Thresholds(_mean(up), _mean(down), _deviation(up), _deviation(down))


def _check_drift(leak_drift_per_s: float) -> None:
    numeric = isinstance(leak_drift_per_s, Real) and not isinstance(leak_drift_per_s, bool)
    if not numeric or not 0.0 <= leak_drift_per_s < math.inf:
        raise FitError(
            f"leak_drift_per_s is {leak_drift_per_s!r}. Allowed is a finite number from 0 ln units "
            "per second. Leave it out if there is no leak."
        )


def _corners(t_us: npt.ArrayLike, log_luminance: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Check the corners of the modulation and return times [µs] and luminance [ln units]."""
    try:
        times, luminance = np.asarray(t_us, np.float64), np.asarray(log_luminance, np.float64)
    except (TypeError, ValueError):
        raise FitError(
            "t_us or log_luminance holds something other than numbers. Allowed are one-dimensional "
            "arrays of numbers. Give one time and one value for each corner."
        ) from None
    if times.ndim != 1 or times.shape != luminance.shape or times.size < 2:
        raise FitError(
            f"t_us has shape {times.shape} and log_luminance has shape {luminance.shape}. Allowed "
            "are two one-dimensional arrays of equal length, from 2. Give the value at each corner."
        )
    if not (np.isfinite(times).all() and np.isfinite(luminance).all()):
        raise FitError(
            "t_us or log_luminance holds NaN or infinity. Allowed are finite numbers. Take the "
            "logarithm of luminances above 0."
        )
    steps = np.diff(times)
    if not (steps > 0.0).all():
        bad = int(np.argmin(steps > 0.0)) + 1
        raise FitError(
            f"corner {bad} is at {times[bad]:g} µs, after one at {times[bad - 1]:g} µs. Allowed "
            "are rising times. Sort the corners by time and leave out duplicates."
        )
    return times, luminance


def _per_pixel(pixel: npt.NDArray[np.int64], step: Floats) -> Floats:
    """Return the median step of each pixel that has one."""
    order = np.argsort(pixel, kind="stable")
    _, first = np.unique(pixel[order], return_index=True)
    return np.array([np.median(part) for part in np.split(step[order], first[1:]) if part.size])


def _mean(values: Floats) -> float | None:
    return float(values.mean()) if values.size else None


def _deviation(values: Floats) -> float | None:
    return float(values.std()) if values.size else None
