"""Estimates the parameters of a sensor from a recording of a static scene.

Every event resets its pixel. From then on two processes compete: shot noise, which arrives at
constant rates, and leak, which takes the memorised value to the ON threshold in a fixed time
T = θ_on/drift. So no interval of a pixel is longer than T, and intervals that leak ends all last T.
A pixel with several ON events after equally long intervals, the longest that it has, shows its
leak period T. Earlier events are shot noise; their rate is their number over the time before T.

What can be estimated from a static recording:

- The shot rates, always.
- The leak rate, if shot noise sometimes leaves a pixel alone for longer than T. In dim light it
  does not, and the leak is None.
- θ_on and its mismatch, from T, if the drift in ln units per second is known. The drift is a
  property of the junction and its illumination, not of the threshold's bias (Nozaki, Delbruck
  2017). Without it, a static recording determines θ_on only up to that factor, and therefore only
  the mismatch relative to the threshold.
- θ_off cannot be estimated by any method. On a static scene nothing moves a pixel towards it: leak
  drifts the other way, and shot noise is a process in time whose rate depends on the illuminance
  and not on the threshold (`emulator.pixel.noise`). Two sensors that differ in θ_off alone give the
  same static recording, event for event (a test proves it), so no function of the recording can
  tell them apart. It takes a known modulation: `emulator.characterisation.ramp_fit` estimates both
  thresholds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real

import numpy as np
import numpy.typing as npt

from emulator.characterisation.recordings import PixelEvents, check_recording, healthy_events
from emulator.errors import FitError
from flybench.events import Events

_TOLERANCE = 0.02
"""Relative difference between intervals that count as equal (assumed: leak is regular to 2 %)."""
_FEWEST_PERIODS = 3
"""Equal intervals that show a leak period: two equal ones occur by chance in one pixel of ten."""
_LEAST_KNOWN = 0.8
"""Share of pixels with a leak period below which no leak is given, since pixels with short periods
would be over-represented."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class StaticFit:
    """Parameters of the healthy pixels, estimated from a static recording.

    Attributes:
        shot_on_hz: ON shot noise of a pixel [Hz].
        shot_off_hz: OFF shot noise of a pixel [Hz].
        leak_hz: leak rate of a pixel with the mean threshold, without shot noise [Hz]; None if too
            few pixels show it.
        theta_on: mean ON threshold [ln units]; None without a leak rate or a drift.
        theta_mismatch: standard deviation of the ON threshold over pixels [ln units]; None without
            a leak rate or a drift.
        relative_mismatch: standard deviation of the ON threshold over its mean; None without a leak
            rate.
        hot_share: share of pixels left out as hot.
    """

    shot_on_hz: float
    shot_off_hz: float
    leak_hz: float | None
    theta_on: float | None
    theta_mismatch: float | None
    relative_mismatch: float | None
    hot_share: float


@dataclass(frozen=True, eq=False)
class _Intervals:
    """Intervals from one event of a pixel to its next, each (n,), sorted by pixel.

    Attributes:
        pixel: number of the pixel.
        interval_s: length of the interval [s].
        on: True if an ON event ended it.
        off: True if an OFF event ended it. If neither is True, the end of the recording ended it.
    """

    pixel: npt.NDArray[np.int64]
    interval_s: Floats
    on: npt.NDArray[np.bool_]
    off: npt.NDArray[np.bool_]


def fit_static(
    events: Events,
    *,
    width: int,
    height: int,
    end_us: int,
    leak_drift_per_s: float | None = None,
) -> StaticFit:
    """Estimate noise rates and the ON threshold from a recording of a static scene.

    Twenty leak periods (some minutes) of a thousand pixels give every parameter within a few per
    cent. The docstring of the module lists the assumptions.

    Args:
        events: sorted by t, at one illuminance.
        width: columns of the sensor [px].
        height: rows of the sensor [px].
        end_us: end of the recording on the clock of the events [µs].
        leak_drift_per_s: drift of the memorised value by leak at that illuminance [ln units/s];
            None: unknown.

    Returns:
        Rates and threshold.

    Raises:
        EventError: the events are not a sorted stream from such a sensor.
        FitError: a width or height is out of range, the end is not finite or is before the last
            event, or the drift is not positive.
    """
    width, height = check_recording(events, width=width, height=height)
    _check_known(events, end_us, leak_drift_per_s)
    by_pixel = healthy_events(events, (height, width))
    healthy = by_pixel.healthy
    intervals = _intervals(by_pixel, end_us)
    periods_s = _leak_periods(intervals, width * height)
    shot_on_hz, shot_off_hz = _shot_rates(intervals, periods_s)
    period_s = periods_s[healthy.ravel()]
    known = np.isfinite(period_s)
    hot_share = 1.0 - float(healthy.mean())
    if period_s.size == 0 or known.mean() < _LEAST_KNOWN:
        return StaticFit(shot_on_hz, shot_off_hz, None, None, None, None, hot_share)
    mean_s = float(period_s[known].mean())
    relative = float(period_s[known].std() / period_s[known].mean())
    theta = None if leak_drift_per_s is None else leak_drift_per_s * mean_s
    mismatch = None if theta is None else theta * relative
    return StaticFit(shot_on_hz, shot_off_hz, 1.0 / mean_s, theta, mismatch, relative, hot_share)


def _check_known(events: Events, end_us: int, leak_drift_per_s: float | None) -> None:
    last_us = int(events["t"][-1]) if events.size else 0
    numeric = isinstance(end_us, Real) and not isinstance(end_us, bool)
    if not numeric or not last_us <= end_us < math.inf:
        raise FitError(
            f"end_us is {end_us!r}. Allowed is a finite number from {last_us}, the time of the "
            "last event. Give the end of the recording on the clock of the events."
        )
    if leak_drift_per_s is None:
        return
    numeric = isinstance(leak_drift_per_s, Real) and not isinstance(leak_drift_per_s, bool)
    if not numeric or not 0.0 < leak_drift_per_s < math.inf:
        raise FitError(
            f"leak_drift_per_s is {leak_drift_per_s!r}. Allowed is a positive finite number of ln "
            "units per second. Pass None if it is unknown."
        )


def _intervals(by_pixel: PixelEvents, end_us: int) -> _Intervals:
    ordered, pixel = by_pixel.events, by_pixel.pixel
    ended = np.append(np.diff(pixel) == 0, np.zeros(min(1, pixel.size), np.bool_))
    until_us = np.where(ended, np.roll(ordered["t"], -1), end_us)
    next_on = np.roll(ordered["p"], -1)
    interval_s = (until_us - ordered["t"]) * 1e-6
    return _Intervals(pixel, interval_s, ended & next_on, ended & ~next_on)


def _leak_periods(intervals: _Intervals, pixels: int) -> Floats:
    """Return the leak period of each pixel, (pixels,) [s]; NaN for a pixel that shows none."""
    pixel, interval_s = intervals.pixel, intervals.interval_s
    longest = np.zeros(pixels)
    np.maximum.at(longest, pixel, interval_s)
    periods = intervals.on & (interval_s >= (1.0 - _TOLERANCE) * longest[pixel])
    number = np.bincount(pixel[periods], minlength=pixels)
    total = np.bincount(pixel[periods], interval_s[periods], minlength=pixels)
    return np.where(number >= _FEWEST_PERIODS, total / np.maximum(number, 1), np.nan)


def _shot_rates(intervals: _Intervals, period_s: Floats) -> tuple[float, float]:
    """Return ON and OFF shot noise [Hz]: events before the leak period ends, over that time."""
    before_leak_s = (1.0 - 2.0 * _TOLERANCE) * np.nan_to_num(period_s, nan=np.inf)[intervals.pixel]
    time_s = float(np.minimum(intervals.interval_s, before_leak_s).sum())
    early = intervals.interval_s < before_leak_s
    if time_s == 0.0:
        return 0.0, 0.0
    on = int(np.count_nonzero(early & intervals.on))
    off = int(np.count_nonzero(early & intervals.off))
    return on / time_s, off / time_s
