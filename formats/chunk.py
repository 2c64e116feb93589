"""Sections of a recording, and their statistics."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from emulator import ApsFrame
from flybench.events import Events
from formats.samples import empty_imu, empty_triggers


@dataclass(frozen=True, eq=False)
class Chunk:
    """A section of a recording.

    Attributes:
        events: events sorted by time, none older than those of the previous chunk; may be empty.
        frames: APS frames whose exposure ends no later than the last event.
        imu: samples of the inertial measurement unit, of `IMU_DTYPE`, in the order of the file.
            Those before the first event have negative times if `EventFile.origin_us` is not 0.
        triggers: triggers, of `TRIGGER_DTYPE`, as `imu`.
    """

    events: Events
    frames: tuple[ApsFrame, ...] = ()
    imu: npt.NDArray[Any] = field(default_factory=empty_imu)
    triggers: npt.NDArray[Any] = field(default_factory=empty_triggers)


@dataclass(frozen=True)
class EventStatistics:
    """Statistics of the part of a recording that has been read.

    Attributes:
        events: number of events.
        on: number of ON events.
        frames: number of APS frames.
        imu: number of IMU samples.
        triggers: number of triggers.
        first_us: time of the first event [µs].
        last_us: time of the last event [µs].
        x_min: leftmost column with an event [px].
        x_max: rightmost column with an event [px].
        y_min: topmost row with an event [px].
        y_max: bottommost row with an event [px].
    """

    events: int = 0
    on: int = 0
    frames: int = 0
    imu: int = 0
    triggers: int = 0
    first_us: int = 0
    last_us: int = 0
    x_min: int = 0
    x_max: int = 0
    y_min: int = 0
    y_max: int = 0

    @property
    def span_us(self) -> int:
        """Time from the first event to the last [µs]."""
        return self.last_us - self.first_us

    @property
    def rate_hz(self) -> float:
        """Mean event rate [events/s]; 0 if all events have the same time."""
        return self.events / self.span_us * 1e6 if self.span_us else 0.0

    @property
    def on_share(self) -> float:
        """Share of ON events, 0 to 1; 0 if there are no events."""
        return self.on / self.events if self.events else 0.0

    def with_chunk(self, chunk: Chunk) -> EventStatistics:
        """Return the statistics with `chunk` included."""
        events, frames = chunk.events, self.frames + len(chunk.frames)
        imu, triggers = self.imu + chunk.imu.size, self.triggers + chunk.triggers.size
        if not events.size:
            return replace(self, frames=frames, imu=imu, triggers=triggers)
        x, y = events["x"], events["y"]
        low = (int(x.min()), int(y.min()))
        high = (int(x.max()), int(y.max()))
        if self.events:
            low = (min(low[0], self.x_min), min(low[1], self.y_min))
            high = (max(high[0], self.x_max), max(high[1], self.y_max))
        return EventStatistics(
            events=self.events + events.size,
            on=self.on + int(np.count_nonzero(events["p"])),
            frames=frames,
            imu=imu,
            triggers=triggers,
            first_us=self.first_us if self.events else int(events["t"][0]),
            last_us=int(events["t"][-1]),
            x_min=low[0],
            x_max=high[0],
            y_min=low[1],
            y_max=high[1],
        )
