"""The change of log light from frame to frame that the events predict.

A frame is the mean of the light over its exposure. From one event to the next, the events give the
light at every moment up to a constant factor, so they predict the blurred frame too: the
event-based double integral (Pan et al., CVPR 2019). Between events, the light lies somewhere
between the thresholds: above the level of an ON event by a share of θ_on on average, or below that
of an OFF event by the same share of θ_off.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from scenarios.calibrate.fits.event_steps import EventSteps
from scenarios.calibrate.recording import CalibrationRecording, PixelEvents

F32 = npt.NDArray[np.float32]
I64 = npt.NDArray[np.int64]

_INSTANT_US = 1e-3
"""Exposure that stands for a frame of one moment [µs]."""


@dataclass(frozen=True, eq=False)
class Predicted:
    """Predicted logarithm of each frame, up to a constant of each pixel, and its derivatives.

    Attributes:
        log: (frames, pixels) logarithm of the level.
        per_on: (frames, pixels) its derivative by θ_on: about the number of ON events before it.
        per_off: (frames, pixels) its derivative by θ_off.
        per_share: (frames, pixels) its derivative by the share.
    """

    log: F32
    per_on: F32
    per_off: F32
    per_share: F32


def predict_frames(
    recording: CalibrationRecording,
    events: PixelEvents,
    pixels: I64,
    steps: EventSteps,
    thresholds: tuple[float, float, float],
) -> Predicted:
    """Predict the frames of some pixels from their events.

    Args:
        recording: the frames.
        events: events by pixel.
        pixels: (m,) numbers of the pixels.
        steps: change at each event.
        thresholds: θ_on, θ_off [ln units], and the share.
    """
    starts, ends, rolling = recording.exposures_us()
    rows, columns = recording.shape
    size = len(recording.frames), pixels.size
    found = Predicted(*(np.empty(size, np.float32) for _ in range(4)))
    _predict(
        events.t,
        events.on,
        events.offsets,
        steps.gain,
        steps.shift,
        pixels,
        pixels // columns / rows,
        steps.lag_us[pixels],
        starts,
        ends,
        rolling,
        *thresholds,
        found.log,
        found.per_on,
        found.per_off,
        found.per_share,
    )
    return found


@compiled
def _predict(
    t: Any,
    on: Any,
    offsets: Any,
    gain: Any,
    shift: Any,
    pixels: Any,
    heights: Any,
    lags: Any,
    starts: Any,
    ends: Any,
    rolling: Any,
    theta_on: float,
    theta_off: float,
    share: float,
    log: Any,
    per_on: Any,
    per_off: Any,
    per_share: Any,
) -> None:
    for i in range(pixels.size):
        n, last = offsets[pixels[i]], offsets[pixels[i] + 1]
        ups = downs = moved = 0.0
        polarity = 0
        for k in range(starts.size):
            start_us = starts[k] + heights[i] * rolling[k] + lags[i]
            end_us = ends[k] + heights[i] * rolling[k] + lags[i]
            while n < last and t[n] <= start_us:
                ups += gain[n] if on[n] else 0.0
                downs += 0.0 if on[n] else gain[n]
                moved += shift[n]
                polarity = 1 if on[n] else -1
                n += 1
            m, up, down, by, sign, now_us = n, 0.0, 0.0, 0.0, polarity, start_us
            total = total_on = total_off = total_share = 0.0
            while True:
                until_us = t[m] if m < last and t[m] < end_us else end_us
                rest = theta_on if sign > 0 else (-theta_off if sign < 0 else 0.0)
                light = math.exp(theta_on * up - theta_off * down + by + share * rest)
                light *= max(until_us - now_us, _INSTANT_US)
                total += light
                total_on += light * (up + (share if sign > 0 else 0.0))
                total_off += light * (down + (share if sign < 0 else 0.0))
                total_share += light * rest
                if until_us >= end_us:
                    break
                up += gain[m] if on[m] else 0.0
                down += 0.0 if on[m] else gain[m]
                by += shift[m]
                sign = 1 if on[m] else -1
                now_us = until_us
                m += 1
            exposure_us = max(end_us - start_us, _INSTANT_US)
            log[k, i] = theta_on * ups - theta_off * downs + moved + math.log(total / exposure_us)
            per_on[k, i] = ups + total_on / total
            per_off[k, i] = -downs - total_off / total
            per_share[k, i] = total_share / total
