"""The events and the frame that a film shows at each moment."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.events import Events, concatenate_events, empty_events
from scenarios.film.material import Part, Picture


@dataclass(frozen=True, eq=False)
class Moment:
    """What is seen at one time.

    Attributes:
        t_us: the time [µs].
        events: events of the time window that ends at `t_us`, inclusive.
        frame: (height, width) latest APS frame; None before the first.
    """

    t_us: int
    events: Events
    frame: npt.NDArray[Any] | None


def moments(parts: Iterable[Part], times_us: Iterable[int], window_us: int) -> Iterator[Moment]:
    """Yield what is seen at each time, and keep only the events of one window.

    Args:
        parts: the stream, in order of time.
        times_us: times in ascending order [µs].
        window_us: duration of the window before each time, from which it shows events [µs].
    """
    stream = iter(parts)
    events, ended = empty_events(), False
    frames: list[Picture] = []
    frame: npt.NDArray[Any] | None = None
    for t_us in times_us:
        while not ended and (not events.size or events["t"][-1] <= t_us):
            part = next(stream, None)
            ended = part is None
            if part is not None:
                events = _after(concatenate_events([events, part[0]]), t_us - window_us)
                frames += part[1]
        while frames and frames[0][0] <= t_us:
            frame = frames.pop(0)[1]
        events = _after(events, t_us - window_us)
        yield Moment(t_us, events[: np.searchsorted(events["t"], t_us, side="right")], frame)


def _after(events: Events, t_us: int) -> Events:
    return events[np.searchsorted(events["t"], t_us, side="right") :]
