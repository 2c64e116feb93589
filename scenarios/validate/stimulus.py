"""The events and frames of each window of a recording."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from detector.metrics import Box
from emulator import ApsFrame
from flybench.events import Events, concatenate_events
from flybench.memory import check_memory, count_memory
from formats import Chunk, EventFile, open_events
from scenarios.options.recording import open_recording
from scenarios.validate.keys import ManifestError
from scenarios.validate.manifest import Recording, Window

_EVENT_BYTES = 40
"""Memory for an event: as read, as a part of its window, and turned (13 bytes each)."""
_FRAME_COPIES = 3
"""Copies of a frame, likewise."""

_ROUNDING_US = 1000
"""A window may end this much after the last event, since times are read to 1 ms (assumed) [µs]."""


@dataclass(frozen=True, eq=False)
class Stimulus:
    """What a sensor sees in a window.

    Attributes:
        events: events sorted by time; times are from the start of the window.
        frames: APS frames whose exposure lies in the window, with times from its start.
        width: columns of the sensor, or of the crop [px].
        height: rows of the sensor, or of the crop [px].
        duration_us: duration of the window [µs].
    """

    events: Events
    frames: tuple[ApsFrame, ...]
    width: int
    height: int
    duration_us: int


@dataclass
class _Part:
    """What has been read of a window."""

    window: Window
    events: list[Events] = field(default_factory=list)
    frames: list[ApsFrame] = field(default_factory=list)


def check_recording(recording: Recording, path: Path) -> None:
    """Check that a file can be opened, and that all crops are inside its sensor.

    Prints what is uncertain about the file.

    Raises:
        FormatError: the file cannot be opened.
        ManifestError: a crop leaves the sensor.
    """
    with open_recording(path, **_options(recording)) as file:
        _boxes(recording, file)


def read_stimuli(recording: Recording, path: Path) -> Sequence[Stimulus]:
    """Return the stimulus of each window, in the order of the manifest.

    Args:
        recording: the recording, with its windows.
        path: its file.

    Raises:
        FormatError: the file cannot be read, or not up to the end of the last window.
        ManifestError: a window ends after the recording, or a crop leaves the sensor.
        MemoryBudgetError: the windows hold too many events and frames.
    """
    parts = [_Part(window) for window in recording.windows]
    with open_events(path, **_options(recording)) as file:
        boxes = _boxes(recording, file)
        _read(recording, file, parts)
        statistics = file.statistics
    if not statistics.events:
        raise ManifestError(f"{path} contains no events. Correct file in {recording.name}.")
    _check_ends(recording, statistics.span_us)
    return [
        _stimulus(part, box, statistics.first_us, statistics.last_us)
        for part, box in zip(parts, boxes, strict=True)
    ]


def _read(recording: Recording, file: Iterable[Chunk], parts: Sequence[_Part]) -> None:
    """Collect the events of all windows in one pass, which stops after the last window."""
    first_us: int | None = None
    needed = 0
    for chunk in file:
        if first_us is None and chunk.events.size:
            first_us = int(chunk.events["t"][0])
        if first_us is None:
            continue
        for part in parts:
            frames = [f for f in chunk.frames if _is_inside(f, part.window, first_us)]
            events = _inside(chunk.events, part.window, first_us)
            part.frames += frames
            part.events += [events] if events.size else []  # an empty view would keep the chunk
            needed += _needed_bytes(events, frames)
        check_memory(f"The list of events of the windows of {recording.name}", needed)
        if all(_is_after(chunk, part.window, first_us) for part in parts):
            return


def _needed_bytes(events: Events, frames: Sequence[ApsFrame]) -> int:
    frame_bytes = sum(frame.image.nbytes for frame in frames)
    return events.size * _EVENT_BYTES + frame_bytes * _FRAME_COPIES


def _options(recording: Recording) -> dict[str, Any]:
    return {
        "size": recording.size,
        "format": recording.format,
        "time_unit": recording.time_unit,
        "columns": recording.columns,
    }


def _boxes(recording: Recording, file: EventFile) -> list[Box]:
    """Return the part of the sensor that each window uses."""
    whole = (0, 0, file.width, file.height)
    boxes = [window.crop or whole for window in recording.windows]
    for box in boxes:
        if box[2] > file.width or box[3] > file.height:
            raise ManifestError(
                f"{recording.name}: crop is {list(box)} and the sensor has {file.width} × "
                f"{file.height} px. Allowed is a box inside the sensor. Correct crop, or give size."
            )
    return boxes


def _check_ends(recording: Recording, span_us: int) -> None:
    for window in recording.windows:
        end_us = window.from_us if window.to_us is None else window.to_us
        if end_us > span_us + _ROUNDING_US:
            name = "from_s" if window.to_us is None else "to_s"
            raise ManifestError(
                f"{recording.name}: {name} is {end_us * 1e-6:g} and the last event is at "
                f"{span_us * 1e-6:.6f} s. Allowed is a time in the recording. Correct {name}."
            )


def _inside(events: Events, window: Window, first_us: int) -> Events:
    first = np.searchsorted(events["t"], window.from_us + first_us)
    end = events.size
    if window.to_us is not None:
        end = int(np.searchsorted(events["t"], window.to_us + first_us))
    return events[first:end]


def _is_inside(frame: ApsFrame, window: Window, first_us: int) -> bool:
    starts = frame.start_us - first_us >= window.from_us
    return starts and (window.to_us is None or frame.end_us - first_us <= window.to_us)


def _is_after(chunk: Chunk, window: Window, first_us: int) -> bool:
    """Return True if a chunk reaches beyond a window by more than its end may be rounded."""
    if window.to_us is None or not chunk.events.size:
        return False
    return int(chunk.events["t"][-1]) - first_us > window.to_us + _ROUNDING_US


def _stimulus(part: _Part, box: Box, first_us: int, last_us: int) -> Stimulus:
    """Crop what was read of a window, and count its time from its start."""
    x0, y0, x1, y1 = box
    start_us = first_us + part.window.from_us
    end_us = last_us + 1 if part.window.to_us is None else first_us + part.window.to_us
    events = concatenate_events(part.events)
    x, y = events["x"], events["y"]
    events = events[(x >= x0) & (x < x1) & (y >= y0) & (y < y1)]
    events["t"] -= start_us
    events["x"] -= x0
    events["y"] -= y0
    frames = tuple(
        replace(
            frame,
            start_us=frame.start_us - start_us,
            end_us=frame.end_us - start_us,
            image=np.ascontiguousarray(frame.image[y0:y1, x0:x1]),
        )
        for frame in part.frames
    )
    stimulus = Stimulus(events, frames, x1 - x0, y1 - y0, end_us - start_us)
    count_memory(stimulus, "A window of a recording", _needed_bytes(events, frames))
    return stimulus
