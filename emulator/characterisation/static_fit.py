"""The other way round: what a sensor is, from what it says of a scene that does not change.

Every event resets its pixel. From then on two things compete: shot noise, which comes at constant
rates, and leak, which takes the memorised value to the ON threshold in a time T = θ_on/drift, the
same every time. So in a pixel no wait is longer than T, and waits that end by leak are all T long:
a pixel with several ON events after equally long waits, the longest it has, shows its clock. Shot
noise is what comes before the clock strikes, counted over the time that was open to it.

What can be known, and what not:

- The shot rates, always.
- The leak's rate, where shot noise leaves a pixel alone for longer than T now and then. In dim
  light it doesn't, and the leak is None.
- θ_on and its mismatch, from T, where the drift in ln units per second is known: it is a property
  of the junction and its light, not of the threshold's bias (Nozaki, Delbruck 2017). Without it a
  static recording gives θ_on up to that factor, hence the mismatch relative to the threshold.
- θ_off, never, whatever the method: on a static scene nothing moves a pixel towards it, since leak
  drifts the other way, and shot noise is a process in time whose rate follows the light and not
  the threshold (`emulator.pixel.noise`). Two sensors that differ in θ_off alone give one and the
  same static recording, event for event (a test holds that), so that no function of it can tell
  them apart. It takes a known modulation: `emulator.characterisation.ramp_fit` gives both
  thresholds.
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

_LIKE = 0.02
"""How far equally long waits may differ (assumed: leak is a clock to within 2 %)."""
_STRIKES = 3
"""Equally long waits that make a clock: two come about by chance in one pixel of ten."""
_LEAST_CLOCKS = 0.8
"""Share of pixels with a clock below which the leak is not given: those with short waits would be
over-represented."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class StaticFit:
    """What a static recording tells about the healthy pixels.

    Attributes:
        shot_on_hz: ON shot noise of a pixel [Hz].
        shot_off_hz: OFF shot noise of a pixel [Hz].
        leak_hz: leak of the pixel with the mean threshold, without shot noise [Hz]; None where too
            few pixels show it.
        theta_on: mean ON threshold [ln units]; None without a leak or a drift.
        theta_mismatch: standard deviation of the ON threshold over pixels [ln units]; likewise.
        relative_mismatch: the same over the threshold; None without a leak.
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
class _Waits:
    """Times from one event of a pixel to its next, each (n,), pixel by pixel.

    Attributes:
        pixel: number of the pixel.
        wait_s: how long it waited [s].
        on: whether an ON event ended the wait.
        off: whether an OFF event did; where neither did, the recording ended it.
    """

    pixel: npt.NDArray[np.int64]
    wait_s: Floats
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
    """Estimate noise rates, and the ON threshold, from a scene that does not change.

    A recording of twenty leak intervals (some minutes) of a thousand pixels gives all of them
    within a few per cent; the module tells what is assumed.

    Args:
        events: sorted by t, of one light.
        width: columns of the sensor [px].
        height: rows of the sensor [px].
        end_us: end of the recording, on the events' clock [µs].
        leak_drift_per_s: drift of the memorised value by leak at that light [ln units/s], if known.

    Returns:
        Rates and threshold.

    Raises:
        EventError: the events are no sorted stream from such a sensor.
        FitError: a size that is none, an end that is not finite or before the last event, or a
            drift that is not positive.
    """
    width, height = check_size(width, height)
    check_events(events, width=width, height=height)
    _check_known(events, end_us, leak_drift_per_s)
    healthy = ~hot_pixels(counts(events, (height, width)))
    waits = _waits(events[healthy[events["y"], events["x"]]], width, end_us)
    clocks_s = _clocks(waits, width * height)
    shot_on_hz, shot_off_hz = _shot_rates(waits, clocks_s)
    clock_s = clocks_s[healthy.ravel()]
    known = np.isfinite(clock_s)
    hot_share = 1.0 - float(healthy.mean())
    if clock_s.size == 0 or known.mean() < _LEAST_CLOCKS:
        return StaticFit(shot_on_hz, shot_off_hz, None, None, None, None, hot_share)
    mean_s, relative = (
        float(clock_s[known].mean()),
        float(clock_s[known].std() / clock_s[known].mean()),
    )
    theta = None if leak_drift_per_s is None else leak_drift_per_s * mean_s
    return StaticFit(
        shot_on_hz,
        shot_off_hz,
        1.0 / mean_s,
        theta,
        None if theta is None else theta * relative,
        relative,
        hot_share,
    )


def _check_known(events: Events, end_us: int, leak_drift_per_s: float | None) -> None:
    last_us = int(events["t"][-1]) if events.size else 0
    numeric = isinstance(end_us, Real) and not isinstance(end_us, bool)
    if not numeric or not last_us <= end_us < math.inf:
        raise FitError(
            f"end_us is {end_us!r}; allowed is a finite number from {last_us}, the time of the "
            "last event; give the end of the recording on the events' clock"
        )
    if leak_drift_per_s is None:
        return
    numeric = isinstance(leak_drift_per_s, Real) and not isinstance(leak_drift_per_s, bool)
    if not numeric or not 0.0 < leak_drift_per_s < math.inf:
        raise FitError(
            f"leak_drift_per_s is {leak_drift_per_s!r}; allowed is a positive finite number of ln "
            "units per second; pass None if it is not known"
        )


def _waits(events: Events, width: int, end_us: int) -> _Waits:
    order = np.lexsort((events["t"], events["x"], events["y"]))
    ordered = events[order]
    pixel = ordered["y"].astype(np.int64) * width + ordered["x"]
    ended = np.append(np.diff(pixel) == 0, np.zeros(min(1, pixel.size), np.bool_))
    until = np.where(ended, np.roll(ordered["t"], -1), end_us)
    next_on = np.roll(ordered["p"], -1)
    wait_s = (until - ordered["t"]) * 1e-6
    return _Waits(pixel, wait_s, ended & next_on, ended & ~next_on)


def _clocks(waits: _Waits, pixels: int) -> Floats:
    """(pixels,) leak intervals [s], NaN where a pixel shows none."""
    longest = np.zeros(pixels)
    np.maximum.at(longest, waits.pixel, waits.wait_s)
    strikes = waits.on & (waits.wait_s >= (1.0 - _LIKE) * longest[waits.pixel])
    number = np.bincount(waits.pixel[strikes], minlength=pixels)
    total = np.bincount(waits.pixel[strikes], waits.wait_s[strikes], minlength=pixels)
    return np.where(number >= _STRIKES, total / np.maximum(number, 1), np.nan)


def _shot_rates(waits: _Waits, clock_s: Floats) -> tuple[float, float]:
    """ON and OFF shot noise [Hz]: events before the clock strikes, over the time before it does."""
    open_s = (1.0 - 2.0 * _LIKE) * np.nan_to_num(clock_s, nan=np.inf)[waits.pixel]
    time_s = float(np.minimum(waits.wait_s, open_s).sum())
    early = waits.wait_s < open_s
    if time_s == 0.0:
        return 0.0, 0.0
    on = int(np.count_nonzero(early & waits.on))
    off = int(np.count_nonzero(early & waits.off))
    return on / time_s, off / time_s
