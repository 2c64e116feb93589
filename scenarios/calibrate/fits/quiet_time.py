"""Pixels and times at which only noise, leak and hot pixels cause events.

Frames tell where the light does not change: neither at a pixel and its neighbours, nor on average
over a block of 8×8 pixels, which shows what is too dark for a single pixel. Events tell the rest:
where those of a block are simultaneous more often than by chance, something moves or flickers
(`event_statistics.quiet_pixels`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.ndimage import binary_dilation, uniform_filter

from scenarios.calibrate.fits.frame_noise import frame_noise
from scenarios.calibrate.recording import CalibrationRecording
from scenarios.event_statistics.quiet_pixels import BLOCK_PX, SimultaneousPairs

_DEVIATIONS = 5.0
"""Standard deviations of a change that is no noise of the frames (assumed)."""
_CALM = 0.9
"""Share of still pixels from which the whole image counts as still (assumed)."""
_DARKEST_DN = 8.0
"""Lowest mean level that tells the illuminance: two steps of a converter with 8 bits (assumed)."""
_FIRST_COUNTS = 3
"""Factor by which the first run of still time counts as longer (assumed)."""
_SETTLING_US, _SETTLING_SHARE = 1_000_000, 0.33
"""Time that pixels need to settle, and the largest share of the still time for it (assumed)."""

B1 = npt.NDArray[np.bool_]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class QuietTime:
    """Events of quiet pixels in quiet time.

    Attributes:
        lux: (n,) mean illuminance of each quiet pixel [lux].
        seconds: (n,) quiet time of each [s].
        on: (n,) ON events in this time.
        off: (n,) OFF events in this time.
        settled: (n,) True if the time starts with the recording. After motion, the memory of a
            pixel can be anywhere between the thresholds, and leak takes long to reach one.
    """

    lux: F64
    seconds: F64
    on: I64
    off: I64
    settled: B1

    def of(self, chosen: B1) -> QuietTime:
        """Return some of the pixels."""
        return QuietTime(
            self.lux[chosen],
            self.seconds[chosen],
            self.on[chosen],
            self.off[chosen],
            self.settled[chosen],
        )


def quiet_time(recording: CalibrationRecording) -> QuietTime:
    """Return the quiet pixels of a recording, with their events in the longest still time."""
    still = _still_intervals(recording)
    calm = still.mean(axis=(1, 2)) >= _CALM
    own = _quiet_pixels(recording, still)
    # What is too dark for the frames may be quiet at least while the whole image is still.
    common = _quiet_pixels(recording, still & calm[:, None, None])
    known = own[0] | common[0]
    lux, seconds, on, off, settled = (
        np.where(own[0], first, second)[known]
        for first, second in zip(own[1:], common[1:], strict=True)
    )
    return QuietTime(lux, seconds, on, off, settled)


def _quiet_pixels(recording: CalibrationRecording, still: B1) -> tuple[B1, F64, F64, I64, I64, B1]:
    """Return which pixels are quiet in their longest still time, and what is known of this time.

    Args:
        recording: the recording.
        still: (frames − 1, rows, columns) True where the light does not change.

    Returns:
        True at quiet pixels, illuminance [lux], time [s], ON events, OFF events, and True at those
        whose time starts with the recording, each (pixels,).
    """
    begin, end = longest_runs(still)
    settled = begin == 0
    begin = _settled(recording, begin, end)
    lux, known = _light_within(recording, begin, end)
    starts, ends, _ = recording.exposures_us()
    middles = (starts + ends) // 2
    events = recording.events
    rows, columns = recording.shape
    pixel = events["y"].astype(np.int64) * columns + events["x"]
    kept = (events["t"] >= middles[begin][pixel]) & (events["t"] < middles[end][pixel])
    seconds = (middles[end] - middles[begin]) * 1e-6
    pairs = SimultaneousPairs(width=columns, height=rows)
    pairs.add(events[kept])
    longest_us = max(1, round(1e6 * float(seconds.max(initial=0.0))))
    quiet = pairs.quiet_pixels(longest_us).ravel() & (seconds > 0.0) & known
    on, off = (
        np.bincount(pixel[kept & (events["p"] == is_on)], minlength=rows * columns)
        for is_on in (True, False)
    )
    return quiet, lux, seconds, on, off, settled


def longest_runs(still: B1) -> tuple[I64, I64]:
    """Return begin and end of the longest run of True of each pixel, each (pixels,).

    The first run counts as longer than it is, since pixels have settled in it.

    Args:
        still: (intervals, rows, columns).
    """
    flat = still.reshape(len(still), -1)
    begin, end, since = (np.zeros(flat.shape[1], np.int64) for _ in range(3))
    for k, now in enumerate(flat):
        weight = np.where(begin == 0, _FIRST_COUNTS, 1)
        longer = now & ((k + 1 - since > weight * (end - begin)) | (since == begin))
        begin, end = np.where(longer, since, begin), np.where(longer, k + 1, end)
        since = np.where(now, since, k + 1)
    return begin, end


def _settled(recording: CalibrationRecording, begin: I64, end: I64) -> I64:
    """Return the frame from which noise has settled: motion leaves pixels near a threshold."""
    starts, _, _ = recording.exposures_us()
    waited = np.minimum(_SETTLING_US, (starts[end] - starts[begin]) * _SETTLING_SHARE)
    found = np.searchsorted(starts, starts[begin] + waited)
    return np.asarray(np.where(begin == 0, 0, np.minimum(found, end)))


def _light_within(recording: CalibrationRecording, begin: I64, end: I64) -> tuple[F64, B1]:
    """Return the mean illuminance over the frames from `begin` to `end`, and if they can tell it.

    They cannot where a frame saturates, or where all are as dark as their black level.
    """
    total, levels_sum, number = (np.zeros(begin.size) for _ in range(3))
    below = np.ones(begin.size, np.bool_)
    for k, (frame, lux) in enumerate(zip(recording.frames, recording.lux_per_level, strict=True)):
        inside, levels = (begin <= k) & (k <= end), frame.image.ravel()
        total += np.where(inside, lux * levels, 0.0)
        levels_sum += np.where(inside, levels, 0)
        number += inside
        below &= ~inside | (levels < recording.saturation)
    number = np.maximum(number, 1.0)
    return total / number, below & (levels_sum >= _DARKEST_DN * number)


def _still_intervals(recording: CalibrationRecording) -> B1:
    """Return (frames − 1, rows, columns) True where nothing changes, nor just before and after."""
    changes = np.stack(
        [_changed(recording, k, noise) for k, noise in enumerate(frame_noise(recording))]
    )
    wide = binary_dilation(changes, np.ones((3, 1, 1)))
    return np.asarray(~binary_dilation(wide, np.ones((1, 5, 5))))


def _changed(recording: CalibrationRecording, k: int, noise: F64) -> B1:
    """Return (rows, columns) True where frame k + 1 differs from frame k."""
    before, after = (recording.frames[n].image.astype(np.float64) for n in (k, k + 1))
    ratio = recording.lux_per_level[k + 1] / recording.lux_per_level[k]
    deviation = noise * np.hypot(1.0, ratio)
    change = (after * ratio - before) / deviation
    block = uniform_filter(change, BLOCK_PX) * BLOCK_PX
    return np.asarray((np.abs(change) > _DEVIATIONS) | (np.abs(block) > _DEVIATIONS))
