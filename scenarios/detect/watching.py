"""A file passes before a detector, in constant memory."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from detector.estimate import Detector, MotionEstimate
from detector.fly.detector import FlyMaps
from emulator import ApsFrame
from flybench.events import Events, empty_events
from formats import Chunk, EventFile
from scenarios.pipeline.feeding import feed

PIECE_US = 10_000
"""What is passed at once: the detectors' hop, so that a fly's maps are those of its estimate."""


@dataclass(frozen=True, eq=False)
class Look:
    """A piece of a recording, and what the detector said to it.

    Attributes:
        events: the next, sorted; times are the file's.
        frames: whose exposure ended with these events or before.
        estimates: what became due; times are the file's.
        maps: the fly's at the last of them; None of another detector.
        start_us: when the detector's time began [µs].
    """

    events: Events
    frames: tuple[ApsFrame, ...]
    estimates: tuple[MotionEstimate, ...]
    maps: FlyMaps | None
    start_us: int


def watch(file: EventFile, detector: Detector) -> Iterator[Look]:
    """Pass a recording before a fresh detector.

    The detector's time starts with the hop in which the recording starts, so that a file whose
    times are large costs no more than one that starts at 0.

    Yields:
        Pieces in order of time.

    Raises:
        FormatError: the file is broken; what came before was given.
        MethodError: the detector does not obey its protocol.
    """
    shift_us: int | None = None
    said: tuple[MotionEstimate, ...] = ()
    now_us = 0
    for chunk in file:
        if shift_us is None:
            shift_us = _first_us(chunk) // PIECE_US * PIECE_US
        for events, frames in _pieces(chunk):
            mine, shown = _shifted(events, shift_us), _in_order(frames, shift_us, now_us)
            ends = [frame.end_us for frame in shown]
            now_us = max([now_us, *ends, *mine["t"][-1:].tolist()])
            estimates = feed(detector, mine, until_us=now_us, frames=shown, earlier=said)
            said = tuple(estimates[-1:]) or said
            yield _look(events, frames, estimates, detector, shift_us)
    if shift_us is not None:
        estimates = feed(detector, empty_events(), until_us=now_us + 1, earlier=said)
        yield _look(empty_events(), (), estimates, detector, shift_us)


def maps_of(detector: Detector) -> FlyMaps | None:
    """What a fly saw at its last estimate; another detector has no such maps."""
    maps = getattr(detector, "maps", None)
    return maps if isinstance(maps, FlyMaps) else None


def _look(
    events: Events,
    frames: tuple[ApsFrame, ...],
    estimates: list[MotionEstimate],
    detector: Detector,
    shift_us: int,
) -> Look:
    told = tuple(replace(e, t_us=int(e.t_us) + shift_us) for e in estimates)
    return Look(events, frames, told, maps_of(detector), shift_us)


def _first_us(chunk: Chunk) -> int:
    starts = [frame.start_us for frame in chunk.frames]
    return int(min(starts + chunk.events["t"][:1].tolist(), default=0))


def _pieces(chunk: Chunk) -> Iterator[tuple[Events, tuple[ApsFrame, ...]]]:
    """Events of one hop each, a frame with those that reach its end."""
    events, frames = chunk.events, chunk.frames
    if not events.size:
        yield events, frames
        return
    cuts = np.flatnonzero(np.diff(events["t"] // PIECE_US)) + 1
    for piece in np.split(events, cuts):
        due = sum(frame.end_us <= piece["t"][-1] for frame in frames)
        yield piece, frames[:due]
        frames = frames[due:]
    if frames:
        yield events[:0], frames


def _shifted(events: Events, shift_us: int) -> Events:
    if not shift_us:
        return events
    mine = events.copy()
    mine["t"] -= shift_us
    return mine


def _in_order(frames: tuple[ApsFrame, ...], shift_us: int, now_us: int) -> tuple[ApsFrame, ...]:
    """Frames in the detector's time; one that the file brings late ends when it comes."""
    shown = []
    for frame in frames:
        now_us = max(now_us + 1, frame.end_us - shift_us)
        shown.append(replace(frame, start_us=frame.start_us - shift_us, end_us=now_us))
    return tuple(shown)
