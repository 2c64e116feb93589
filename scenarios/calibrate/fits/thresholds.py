"""Both thresholds and their mismatch, from the change of log light between frames and event counts.

Between two frames of a pixel, the logarithm of the light changes by θ_on for every ON event and by
−θ_off for every OFF event, up to what is left below the thresholds (Wang, Ng, van Goor, Mahony,
"Event Camera Calibration of Per-pixel Biased Contrast Threshold", ACRA 2019, arXiv 2012.09378:
hybrid calibration with intensity images). Here, frames may be blurred (`frame_changes`), and events
on steep edges and with noise count for what they stand for (`event_steps`).

Least squares would give thresholds that are too low, because the rest below the thresholds is an
error of the counts. The changes of the frames are therefore used as instruments: they do not
correlate with it (Wright 1928; Reiersøl 1945: the method of instrumental variables).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator import SensorConfig
from scenarios.calibrate.fits.event_steps import event_steps
from scenarios.calibrate.fits.frame_changes import Predicted, predict_frames
from scenarios.calibrate.fits.frame_noise import frame_noise
from scenarios.calibrate.recording import (
    LEAST_LEVEL,
    CalibrationRecording,
    PixelEvents,
)

LEAST_CHANGE = 0.4
"""Change between frames from which it is used [ln units]: above the noise of frames (assumed)."""
_DEVIATIONS = 6.0
"""Least change in standard deviations of the noise of the darker frame (assumed)."""
FEWEST = 300
"""Fewest changes in each direction that give a threshold (assumed)."""
_MOST_VALUES = 4_000_000
"""Most values of frames × pixels that are used; pixels are left out evenly (assumed)."""
_ROUNDS = 8
_START = (0.25, 0.25, 0.4)
"""Thresholds and share that the fit starts from; it does not depend on them."""
_CLIP = 2.5
"""Residuals above this number of standard deviations weigh less (Huber 1964)."""
_GROUPS = 6
"""Groups of pixels along each side, for the jackknife (Tukey 1958)."""

F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ThresholdFit:
    """Thresholds and what they rest on.

    Attributes:
        theta_on: ON threshold [ln units].
        theta_off: OFF threshold [ln units].
        share: mean rest below the threshold, as a share of it.
        errors: (2,) standard errors of the thresholds.
        measured: (n,) changes of the frames that were used [ln units].
        predicted: (n,) changes that the events predict.
        spread: (m, 2) residual over the whole recording, and number of events √(n_on² + n_off²),
            of each pixel.
        counts: number of rises and of falls that were used.
    """

    theta_on: float
    theta_off: float
    share: float
    errors: F64
    measured: F64
    predicted: F64
    spread: F64
    counts: tuple[int, int]


def fit_thresholds(
    recording: CalibrationRecording, events: PixelEvents, sensor: SensorConfig
) -> ThresholdFit | None:
    """Estimate the thresholds; None if too few pixels change between frames.

    Args:
        recording: the recording.
        events: its events by pixel.
        sensor: refractory period, bandwidths and noise.
    """
    pixels = _used_pixels(recording)
    levels = recording.levels()[:, pixels].astype(np.float64)
    usable = (levels >= LEAST_LEVEL) & (levels < recording.saturation)
    measured = np.diff(np.log(np.maximum(levels, 1.0)), axis=0)
    used = (
        usable[1:] & usable[:-1] & (np.abs(measured) >= _least_changes(recording, pixels, levels))
    )
    used &= _within_events(recording)[:, None]
    counts = int((used & (measured > 0)).sum()), int((used & (measured < 0)).sum())
    if min(counts) < FEWEST:
        return None
    y, lux = measured[used], recording.mean_lux()
    group = _groups(recording.shape)[pixels]
    group = np.broadcast_to(group, used.shape)[used]
    found, scale = np.array(_START), math.inf
    for _ in range(_ROUNDS):
        steps = event_steps(events, lux, sensor, float(found[0]), float(found[1]))
        thresholds = float(found[0]), float(found[1]), float(found[2])
        predicted = predict_frames(recording, events, pixels, steps, thresholds)
        residual, moments = _moments(predicted, y, used, scale)
        scale = 1.4826 * float(np.median(np.abs(residual)))
        left, right = moments[..., :3].sum(axis=0), moments[..., 3].sum(axis=0)
        change = _solve(left, right)
        if change is None:
            return None
        found = np.clip(found + change, (0.01, 0.01, 0.0), (3.0, 3.0, 1.5))
    errors = _jackknife(moments, group)
    spread = _long_residuals(predicted, levels, usable)
    return ThresholdFit(
        float(found[0]),
        float(found[1]),
        float(found[2]),
        errors[:2],
        y,
        y - residual,
        spread,
        counts,
    )


def _used_pixels(recording: CalibrationRecording) -> I64:
    rows, columns = recording.shape
    stride = max(1, math.ceil(rows * columns * len(recording.frames) / _MOST_VALUES))
    return np.arange(0, rows * columns, stride)


def _least_changes(recording: CalibrationRecording, pixels: I64, levels: F64) -> F64:
    """Return the change of each pixel between frames from which it is used, (frames − 1, m)."""
    noise = np.stack([values.ravel()[pixels] for values in frame_noise(recording)])
    darker = np.minimum(levels[1:], levels[:-1])
    return np.asarray(np.maximum(LEAST_CHANGE, _DEVIATIONS * noise / np.maximum(darker, 1.0)))


def _within_events(recording: CalibrationRecording) -> npt.NDArray[np.bool_]:
    """Return (frames − 1,) True where both frames are exposed while there are events."""
    starts, ends, rolling = recording.exposures_us()
    first_us, last_us = recording.span_us
    inside = (starts >= first_us - 1000) & (ends + rolling <= last_us + 1000)
    return np.asarray(inside[1:] & inside[:-1])


def _groups(shape: tuple[int, int]) -> I64:
    row, column = np.indices(shape)
    row, column = row * _GROUPS // shape[0], column * _GROUPS // shape[1]
    return np.asarray((row * _GROUPS + column).ravel())


def _moments(
    predicted: Predicted, y: F64, used: npt.NDArray[np.bool_], scale: float
) -> tuple[F64, F64]:
    """Return residuals, and instruments × (derivatives, residual) of each change, (n, 3, 4)."""
    change, *slopes = (
        np.diff(values, axis=0)[used].astype(np.float64)
        for values in (predicted.log, predicted.per_on, predicted.per_off, predicted.per_share)
    )
    residual = y - change
    weight = np.minimum(1.0, _CLIP * scale / np.maximum(np.abs(residual), 1e-9))
    instruments = np.stack([np.maximum(y, 0.0), np.maximum(-y, 0.0), slopes[2]]) * weight
    columns = np.stack([*slopes, residual])
    return residual, np.einsum("in,jn->nij", instruments, columns)


def _solve(left: F64, right: F64) -> F64 | None:
    try:
        return np.asarray(np.linalg.solve(left, right))
    except np.linalg.LinAlgError:
        return None


def _jackknife(moments: F64, group: I64) -> F64:
    """Return the standard errors, from leaving out one group of pixels after another."""
    total = moments.sum(axis=0)
    left_out = []
    for number in np.unique(group):
        rest = total - moments[group == number].sum(axis=0)
        change = _solve(rest[:, :3], rest[:, 3])
        if change is not None:
            left_out.append(change)
    values = np.array(left_out)
    share = (len(values) - 1) / max(len(values), 1)
    return np.asarray(np.sqrt(share * ((values - values.mean(axis=0)) ** 2).sum(axis=0)))


def _long_residuals(predicted: Predicted, levels: F64, usable: npt.NDArray[np.bool_]) -> F64:
    """Return residual and √(n_on² + n_off²) of each pixel, from its first usable frame to its last.

    Over a long time the rest below the thresholds no longer matters, and the residual shows by how
    much the thresholds of this pixel differ from the mean.
    """
    some = np.count_nonzero(usable, axis=0) >= 2
    usable, column = usable[:, some], np.flatnonzero(some)
    first, last = usable.argmax(axis=0), len(usable) - 1 - usable[::-1].argmax(axis=0)
    log, on, off = (
        (values[last, column] - values[first, column]).astype(np.float64)
        for values in (predicted.log, predicted.per_on, predicted.per_off)
    )
    measured = np.log(levels[last, column] / levels[first, column])
    return np.stack([measured - log, np.hypot(on, off)], axis=1)


def fit_mismatch(fit: ThresholdFit) -> float | None:
    """Return the standard deviation of a threshold over the pixels [ln units]; None: not told.

    The residual of a pixel over the whole recording has the variance r² + m²·(n_on² + n_off²), with
    r² that of a single change and m the mismatch.
    """
    residual, events = np.abs(fit.spread[:, 0]), fit.spread[:, 1]
    rest = 1.4826 * float(np.median(np.abs(fit.measured - fit.predicted)))
    many = events >= 3.0 * rest / (0.05 * (fit.theta_on + fit.theta_off))
    if np.count_nonzero(many) < FEWEST:
        return None
    residual, events = residual[many], events[many]
    mismatch = 0.05
    for _ in range(30):
        mismatch = 1.4826 * float(
            np.median(residual / np.hypot(events, rest / max(mismatch, 1e-4)))
        )
    return mismatch
