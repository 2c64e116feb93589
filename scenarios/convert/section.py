"""A section of a recording: a span of time and a part of the sensor."""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace
from operator import add, sub
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from emulator import ApsFrame
from formats import Chunk

LATEST_US = 2**62
"""End of a section without an end [µs]."""


class Crop(NamedTuple):
    """Part of a sensor: columns x0 to x1 - 1, and rows y0 to y1 - 1 [px]."""

    x0: int
    y0: int
    x1: int
    y1: int


@dataclass(frozen=True)
class Counts:
    """Numbers of events, frames, IMU samples and triggers."""

    events: int = 0
    frames: int = 0
    imu: int = 0
    triggers: int = 0

    @classmethod
    def of(cls, chunk: Chunk) -> Counts:
        """Return the counts of one chunk."""
        return cls(chunk.events.size, len(chunk.frames), chunk.imu.size, chunk.triggers.size)

    def __add__(self, other: Counts) -> Counts:
        """Return the sums."""
        return Counts(*map(add, astuple(self), astuple(other)))

    def __sub__(self, other: Counts) -> Counts:
        """Return the differences."""
        return Counts(*map(sub, astuple(self), astuple(other)))


@dataclass(frozen=True)
class Section:
    """A section of a recording.

    Attributes:
        from_us: its start, inclusive [µs].
        to_us: its end, exclusive [µs].
        crop: its part of the sensor, whose first pixel becomes pixel 0, 0; None: all of it.
    """

    from_us: int = -LATEST_US
    to_us: int = LATEST_US
    crop: Crop | None = None

    def in_time(self, chunk: Chunk) -> Chunk:
        """Return what lies in the span of time; of frames, those whose whole exposure does."""
        frames = (f for f in chunk.frames if self.from_us <= f.start_us and f.end_us < self.to_us)
        events = chunk.events[slice(*np.searchsorted(chunk.events["t"], self._bounds))]
        return Chunk(events, tuple(frames), self._samples(chunk.imu), self._samples(chunk.triggers))

    def in_crop(self, chunk: Chunk) -> Chunk:
        """Return the chunk with the events and frames of the part of the sensor."""
        if self.crop is None:
            return chunk
        x0, y0, x1, y1 = self.crop
        x, y = chunk.events["x"], chunk.events["y"]
        events = chunk.events[(x >= x0) & (x < x1) & (y >= y0) & (y < y1)]
        events["x"] -= x0
        events["y"] -= y0
        frames = tuple(_cropped(frame, self.crop) for frame in chunk.frames)
        return replace(chunk, events=events, frames=frames)

    @property
    def _bounds(self) -> tuple[int, int]:
        return self.from_us, self.to_us

    def _samples(self, samples: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return samples[(samples["t"] >= self.from_us) & (samples["t"] < self.to_us)]


def _cropped(frame: ApsFrame, crop: Crop) -> ApsFrame:
    image = frame.image[crop.y0 : crop.y1, crop.x0 : crop.x1]
    return replace(frame, image=np.ascontiguousarray(image))
