"""The recording that a sensor is calibrated from: events by pixel, and frames."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from emulator import ApsConfig, ApsFrame
from flybench.events import Events, concatenate_events
from flybench.memory import check_memory
from formats import Chunk
from scenarios.errors import ScenarioError

MAX_FRAMES = 400
"""Most frames of a recording that are used (assumed: 10 s of a DAVIS346 at 40 frames/s)."""
MAX_EVENTS = 60_000_000
"""Most events of a recording that are used (assumed: 6 GB of memory)."""
MIN_FRAMES = 2
_BYTES_PER_EVENT = 100
"""Memory for an event, with the arrays of the fits (assumed)."""
_BYTES_PER_PX = 2
LEAST_LEVEL = 24
"""Lowest level that is used [DN of 10 bits]: six steps of a converter with 8 bits (assumed)."""
_SATURATED = 0.95
"""Share of the highest level of all frames from which a pixel counts as saturated (assumed)."""

F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class CalibrationRecording:
    """Events and frames of a sensor.

    Attributes:
        events: (n,) of `EVENT_DTYPE`, sorted by t.
        frames: frames of the sensor's size, in order of time; a frame of a video is exposed for
            0 µs.
        lux_per_level: (frames,) illuminance on the chip for each level of a frame [lux/DN].
        whole: False if the recording is longer than what is used.
    """

    events: Events
    frames: tuple[ApsFrame, ...]
    lux_per_level: F64
    whole: bool = True

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the sensor."""
        rows, columns = self.frames[0].image.shape
        return int(rows), int(columns)

    @property
    def span_us(self) -> tuple[int, int]:
        """Time of the first and of the last event [µs]."""
        return int(self.events["t"][0]), int(self.events["t"][-1])

    @property
    def duration_s(self) -> float:
        """Time from the first event to the last [s]."""
        first, last = self.span_us
        return (last - first) * 1e-6

    @property
    def saturation(self) -> float:
        """Level from which a pixel counts as saturated [DN]."""
        return _SATURATED * max(int(frame.image.max()) for frame in self.frames)

    def levels(self) -> npt.NDArray[np.uint16]:
        """Return the levels of all frames, (frames, pixels) [DN]."""
        return np.stack([frame.image.ravel() for frame in self.frames])

    def exposures_us(self) -> tuple[I64, I64, I64]:
        """Return start, end and delay of the last row of each frame's exposure, each (frames,)."""
        rolling = np.array([frame.rolling_us for frame in self.frames], np.int64)
        starts = np.array([frame.start_us for frame in self.frames], np.int64)
        ends = np.array([frame.end_us for frame in self.frames], np.int64) - rolling
        return starts, ends, rolling

    def mean_lux(self) -> F64:
        """Return the mean illuminance of each pixel over the frames, (pixels,) [lux]."""
        total = np.zeros(self.frames[0].image.size)
        for frame, lux in zip(self.frames, self.lux_per_level, strict=True):
            total += lux * frame.image.ravel()
        return total / len(self.frames)

    def between(self, start_us: int, end_us: int) -> CalibrationRecording:
        """Return the part with all frames and events in [start_us, end_us).

        Raises:
            ScenarioError: there are too few frames or no events in it.
        """
        kept = [start_us <= f.start_us and f.end_us < end_us for f in self.frames]
        t = self.events["t"]
        part = replace(
            self,
            events=self.events[(t >= start_us) & (t < end_us)],
            frames=tuple(f for f, is_kept in zip(self.frames, kept, strict=True) if is_kept),
            lux_per_level=self.lux_per_level[np.array(kept, np.bool_)],
        )
        check_recording(part, "This part of the recording")
        return part


@dataclass(frozen=True, eq=False)
class PixelEvents:
    """Events sorted by pixel, and then by time.

    Attributes:
        t: (n,) times [µs].
        on: (n,) True for ON.
        pixel: (n,) row × width + column.
        offsets: (pixels + 1,) the events of pixel i are those from offsets[i] to offsets[i + 1].
    """

    t: I64
    on: npt.NDArray[np.bool_]
    pixel: I64
    offsets: I64


def events_by_pixel(events: Events, shape: tuple[int, int]) -> PixelEvents:
    """Sort events by pixel and time."""
    pixel = events["y"].astype(np.int64) * shape[1] + events["x"]
    order = np.argsort(pixel, kind="stable")
    pixel = pixel[order]
    offsets = np.searchsorted(pixel, np.arange(shape[0] * shape[1] + 1))
    return PixelEvents(events["t"][order].astype(np.int64), events["p"][order], pixel, offsets)


def read_recording(
    chunks: Iterable[Chunk], *, width: int, height: int, name: str
) -> tuple[Events, list[ApsFrame], bool]:
    """Read a recording, up to `MAX_FRAMES` frames and `MAX_EVENTS` events.

    Args:
        chunks: sections of the recording, in order of time.
        width: columns of the sensor [px].
        height: rows of the sensor [px].
        name: name of the recording, for messages.

    Returns:
        Events, frames, and True if that is the whole recording.

    Raises:
        ScenarioError: a frame has another size than the sensor.
        MemoryBudgetError: the recording does not fit into the memory budget.
    """
    parts: list[Any] = []
    frames: list[ApsFrame] = []
    count = 0
    for chunk in chunks:
        for frame in chunk.frames:
            if frame.image.shape != (height, width):
                rows, columns = frame.image.shape
                raise ScenarioError(
                    f"{name} contains a frame of {columns}×{rows} px, but events of a sensor of "
                    f"{width}×{height} px. Allowed are frames of the sensor's size. Give the right "
                    "size with --size, or other frames with --frames."
                )
        parts.append(chunk.events)
        frames += chunk.frames
        count += chunk.events.size
        needed = count * _BYTES_PER_EVENT + len(frames) * width * height * _BYTES_PER_PX
        check_memory(f"A calibration from the first {count} events of {name}", needed)
        if len(frames) >= MAX_FRAMES or count >= MAX_EVENTS:
            return concatenate_events(parts), frames[:MAX_FRAMES], False
    return concatenate_events(parts), frames, True


def from_aps(
    events: Events, frames: Sequence[ApsFrame], aps: ApsConfig, *, name: str, whole: bool = True
) -> CalibrationRecording:
    """Return a recording with APS frames, whose levels give the illuminance on the chip.

    Args:
        events: events, sorted by t.
        frames: frames of the sensor's size, in order of time.
        aps: the frame part of the sensor, for its electrons per lux and per level.
        name: name of the recording, for messages.
        whole: False if the recording is longer than these events.

    Raises:
        ScenarioError: nothing can be calibrated from the recording; the message states why.
    """
    seconds = np.array([frame.exposure_us for frame in frames]) * 1e-6
    per_level = aps.electrons_per_dn / (aps.electrons_per_lux_s * np.maximum(seconds, 1e-6))
    recording = CalibrationRecording(events, tuple(frames), per_level, whole)
    check_recording(recording, name)
    return recording


def check_recording(recording: CalibrationRecording, name: str) -> None:
    """Check that a sensor can be calibrated from a recording.

    Raises:
        ScenarioError: it has too few frames, no events, or they are not of the same time; or the
            frames show nothing that changes.
    """
    frames, events = recording.frames, recording.events
    if len(frames) < MIN_FRAMES:
        number = "no frames" if not frames else "one frame"
        raise ScenarioError(
            f"{name} has {number}. Allowed are recordings with {MIN_FRAMES} frames or more, "
            "because thresholds come from the change between frames. Record frames too, or give a "
            "video with --frames."
        )
    if events.size == 0 or recording.duration_s == 0.0:
        raise ScenarioError(
            f"{name} contains {events.size} events in 0 s. Allowed are recordings with events at "
            "two times or more. Record it again, or give another file."
        )
    first_us, last_us = recording.span_us
    starts, ends, _ = recording.exposures_us()
    inside = np.count_nonzero((starts <= last_us) & (ends >= first_us))
    if inside < MIN_FRAMES:
        raise ScenarioError(
            f"{name} has events from {first_us * 1e-6:.3f} to {last_us * 1e-6:.3f} s, and frames "
            f"from {starts[0] * 1e-6:.3f} to {ends[-1] * 1e-6:.3f} s; {inside} frames are within "
            f"the events. Allowed are {MIN_FRAMES} or more. Give frames of the same time."
        )
    if all(np.array_equal(frames[0].image, frame.image) for frame in frames[1:]):
        raise ScenarioError(
            f"All {len(frames)} frames of {name} are equal. Allowed are frames of a scene that "
            "changes. Record something that moves, with texture."
        )
