"""Times of the frames of a video, from the time stamps in its file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenarios.emulate.frame_times import FrameTimes, evenly_spaced
from scenarios.errors import ScenarioError

F64 = npt.NDArray[np.float64]

MIN_STAMPED = 0.5
"""Share of the frames whose time stamps must exist to confirm the stated rate (assumed)."""
ROUNDING = 1e-3
"""Error of time stamps that are computed in floating point [ms]."""
LONGER_SOUND_S = 0.25
"""Time by which a sound track may be longer than the frames (assumed)."""
LONGER_SOUND_SHARE = 0.05
"""The same as a share of the length, for short videos (assumed)."""


def video_times(path: Path, stamps_ms: F64, fps: float | None) -> FrameTimes:
    """Return the time of each frame by its own time stamp.

    Matroska, WebM and FLV round time stamps to 1 ms. If all are the rounded times of the stated
    rate, the frames are evenly spaced. Raw streams, MPEG program streams and some AVI files with
    B-frames have no usable time stamps; there, the stated rate counts, with a warning.

    Args:
        path: the video, for messages.
        stamps_ms: time stamp of each frame as OpenCV reports it, 0 if it has none [ms].
        fps: frames per second that the file states; None if it states none.

    Raises:
        ScenarioError: neither time stamps nor a rate.
    """
    if fps is not None and _is_even(stamps_ms, fps):
        return evenly_spaced(stamps_ms.size, fps, "evenly spaced, as the video states")
    if _is_usable(stamps_ms):
        t_us = np.rint(1000 * (stamps_ms - stamps_ms[:1])).astype(np.int64)
        return FrameTimes(t_us, "time stamps of the video")
    if fps is None:
        raise ScenarioError(
            f"{path} states neither its frames per second nor the times of its frames. Give the "
            "rate with --fps, such as --fps 1000."
        )
    frame = int(np.argmin(np.diff(stamps_ms) > 0)) + 1
    warning = (
        f"{path} has no usable time stamps: that of frame {frame} (counted from 0) is missing or "
        f"not later than that of the frame before. The frames are timed at the stated {fps:g} "
        "frames per second. Give --fps if it is another, or convert the video to .mkv."
    )
    times = evenly_spaced(stamps_ms.size, fps, "stated rate of the video")
    return replace(times, warnings=(warning,))


def cut_warnings(
    path: Path, stamps_ms: F64, *, fps: float | None, count: int, start_s: float
) -> tuple[str, ...]:
    """Warn if the frames end well before the stated length.

    The number of frames alone does not tell: many containers state only a length, which includes
    the time before the first frame, that of the last frame, and the sound, and OpenCV multiplies it
    by a mean rate.

    Args:
        path: the video, for messages.
        stamps_ms: time stamp of each frame as OpenCV reports it [ms].
        fps: frames per second that the file states; None if it states none.
        count: number of frames that the file states, or that follows from the stated length; 0 if
            unknown.
        start_s: time of the first frame in the file, from which the time stamps count [s].
    """
    if fps is None or not 1 < stamps_ms.size < count:
        return ()
    t_s = stamps_ms / 1e3 if _is_usable(stamps_ms) else np.arange(stamps_ms.size) / fps
    stated_s = count / fps
    sound_s = min(LONGER_SOUND_S, LONGER_SOUND_SHARE * stated_s)
    last_frame_s = 1.5 * float(np.diff(t_s).max())
    if stated_s - start_s - t_s[-1] <= max(sound_s, last_frame_s):
        return ()
    return (
        f"{path} states a length of {stated_s:.3f} s, but its last frame is at "
        f"{start_s + t_s[-1]:.3f} s. It may be truncated.",
    )


def _is_usable(stamps_ms: F64) -> bool:
    return bool((np.diff(stamps_ms) > 0).all())


def _is_even(stamps_ms: F64, fps: float) -> bool:
    """Return whether the time stamps are those of a constant rate, rounded as in the file.

    Frames without a time stamp, as at the end of an AVI file with B-frames, do not count.
    """
    frame = np.arange(stamps_ms.size)
    stamped = (frame == 0) | (stamps_ms != 0)
    if stamps_ms.size > 1 and stamped.mean() <= MIN_STAMPED:
        return False
    since_ms = (stamps_ms - stamps_ms[:1])[stamped]
    whole = bool((np.abs(since_ms - np.rint(since_ms)) < ROUNDING).all())
    error_ms = np.abs(since_ms - frame[stamped] * (1e3 / fps))
    return bool((error_ms <= (0.5 if whole else 0.0) + ROUNDING).all())
