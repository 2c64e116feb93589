"""Run a detector on a recording, in constant memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyMaps
from emulator import ApsFrame
from flybench.events import Events, empty_events
from formats import Chunk
from scenarios.pipeline.feeding import DetectorFeed, fly_maps

SLICE_US = 10_000
"""Duration of a slice [µs]: the detectors' hop, so that a fly's maps belong to its estimate."""


@dataclass(frozen=True, eq=False)
class RecordingSlice:
    """A time slice of a recording, and the detector's response to it.

    Attributes:
        events: events sorted by time; times are those of the file.
        frames: APS frames whose exposure ends no later than the last event.
        estimates: estimates that became due in the slice; times are those of the file.
        maps: maps of the fly at its last estimate; None for other detectors.
        start_us: time in the file at which the detector's time starts [µs].
    """

    events: Events
    frames: tuple[ApsFrame, ...]
    estimates: tuple[MotionEstimate, ...]
    maps: FlyMaps | None
    start_us: int


def run_detector(
    file: Iterable[Chunk], feed: DetectorFeed, *, until_us: int = 0
) -> Iterator[RecordingSlice]:
    """Run a fresh detector on a recording.

    The detector's time starts at the hop in which the recording starts, so that large timestamps
    cost no more than small ones.

    Args:
        file: the recording, or its chunks.
        feed: a detector that has not seen any events. If it fails, the slices after that have no
            estimates; see `DetectorFeed.failure`.
        until_us: time that the recording reaches, if it is after the last event [µs].

    Yields:
        Slices in order of time.

    Raises:
        FormatError: the file is damaged; the slices before the damage have been yielded.
    """
    start_us: int | None = None
    now_us = 0
    for chunk in file:
        if start_us is None:
            start_us = _first_us(chunk) // SLICE_US * SLICE_US
        for events, frames in _slices(chunk):
            shifted = _shifted(events, start_us)
            shifted_frames = _shifted_frames(frames, start_us, now_us)
            ends = [frame.end_us for frame in shifted_frames]
            now_us = max([now_us, *ends, *shifted["t"][-1:].tolist()])
            estimates = feed.feed(shifted, until_us=now_us, frames=shifted_frames)
            yield _recording_slice(events, frames, estimates, feed, start_us)
    if start_us is not None:
        end_us = max(now_us + 1, until_us - start_us)
        estimates = feed.feed(empty_events(), until_us=end_us)
        yield _recording_slice(empty_events(), (), estimates, feed, start_us)


def _recording_slice(
    events: Events,
    frames: tuple[ApsFrame, ...],
    estimates: list[MotionEstimate],
    feed: DetectorFeed,
    start_us: int,
) -> RecordingSlice:
    in_file_time = tuple(replace(e, t_us=e.t_us + start_us) for e in estimates)
    return RecordingSlice(events, frames, in_file_time, fly_maps(feed.detector), start_us)


def _first_us(chunk: Chunk) -> int:
    starts = [frame.start_us for frame in chunk.frames]
    return int(min(starts + chunk.events["t"][:1].tolist(), default=0))


def _slices(chunk: Chunk) -> Iterator[tuple[Events, tuple[ApsFrame, ...]]]:
    """Yield the events of one hop each; a frame comes with the events that reach its end."""
    events, frames = chunk.events, chunk.frames
    if not events.size:
        yield events, frames
        return
    cuts = np.flatnonzero(np.diff(events["t"] // SLICE_US)) + 1
    for part in np.split(events, cuts):
        due = sum(frame.end_us <= part["t"][-1] for frame in frames)
        yield part, frames[:due]
        frames = frames[due:]
    if frames:
        yield events[:0], frames


def _shifted(events: Events, start_us: int) -> Events:
    if not start_us:
        return events
    shifted = events.copy()
    shifted["t"] -= start_us
    return shifted


def _shifted_frames(
    frames: tuple[ApsFrame, ...], start_us: int, now_us: int
) -> tuple[ApsFrame, ...]:
    """Return frames in the detector's time; a frame that comes late in the file ends on arrival."""
    shifted = []
    for frame in frames:
        now_us = max(now_us + 1, frame.end_us - start_us)
        shifted.append(replace(frame, start_us=frame.start_us - start_us, end_us=now_us))
    return tuple(shifted)
