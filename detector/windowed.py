"""A stream cut into hops, for detectors that look at windows of whole hops."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator

import numpy as np

from detector.errors import DetectorConfigError
from detector.estimate import MotionEstimate
from detector.event_checks import check_chunk, check_order, whole_time
from flybench.events import Events, empty_events, joined

QUIET_LIMIT_US = 60_000_000
"""How long after the last event hops go on [µs]; as `FlyConfig.quiet_limit_us`."""


class HopBuffer:
    """Hands out the events of each whole hop once they are complete, in order.

    HopBuffer begin at whole multiples of their length. After `QUIET_LIMIT_US` without an event they
    stop, and go on with the hop of the next event; a stream that begins later than that starts
    with the hop of its first event, and `advance` beyond that before it hands out nothing.
    """

    def __init__(self, hop_us: int, *, width: int, height: int) -> None:
        """Start at time 0.

        Args:
            hop_us: length of a hop [µs].
            width: sensor columns [px].
            height: sensor rows [px].
        """
        self._hop_us, self._width, self._height = hop_us, width, height
        self._hop = 0
        self._now_us = self._last_event_us = 0
        self._is_fresh = True
        self._pending: list[Events] = []

    def push(self, events: Events) -> Iterator[tuple[int, Events]]:
        """Take the next events; at once, not when the iterator is read.

        Returns:
            End [µs] and events of each hop that ended at or before the last event.

        Raises:
            EventError: not a sorted stream of `EVENT_DTYPE` from this sensor.
            EventOrderError: the first event is older than what was passed or advanced to before.
        """
        check_chunk(events, width=self._width, height=self._height, now_us=self._now_us)
        done: list[tuple[int, Events]] = []
        taken = 0
        while taken < events.size:
            first_us = int(events["t"][taken])
            self._wake(first_us)
            done += self._complete(first_us)
            self._is_fresh = False
            self._skip_quiet(first_us)
            cut = int(np.searchsorted(events["t"], (self._hop + 1) * self._hop_us))
            self._pending.append(joined([events[taken:cut]]))
            self._last_event_us = self._now_us = int(events["t"][cut - 1])
            taken = cut
        return iter(done)

    def advance(self, t_us: int) -> Iterator[tuple[int, Events]]:
        """Learn that every event before `t_us` was passed.

        Returns:
            End [µs] and events of each hop that ended at or before `t_us`.

        Raises:
            EventOrderError: `t_us` is before what was passed or advanced to before, or is no whole
                number.
        """
        t_us = whole_time(t_us)
        check_order(t_us, self._now_us)
        self._now_us = t_us
        self._wake(t_us)
        return iter(self._complete(t_us))

    def _wake(self, t_us: int) -> None:
        """Start with the hop of this time where it comes late and no event was before."""
        if self._is_fresh and t_us > QUIET_LIMIT_US:
            self._skip_quiet(t_us)

    def _complete(self, t_us: int) -> list[tuple[int, Events]]:
        """HopBuffer that end at or before a time, as far as something happened lately."""
        done = []
        last_us = min(t_us, self._last_event_us + QUIET_LIMIT_US)
        while (end_us := (self._hop + 1) * self._hop_us) <= last_us:
            parts = self._pending or [empty_events()]
            done.append((end_us, parts[0] if len(parts) == 1 else joined(parts)))
            self._pending = []
            self._hop += 1
        return done

    def _skip_quiet(self, t_us: int) -> None:
        """Go on with the hop of this time."""
        self._hop = max(self._hop, t_us // self._hop_us)


class WindowedDetector(ABC):
    """Base class of detectors that look at windows of whole hops."""

    def __init__(self, hop_us: int, *, width: int, height: int) -> None:
        """Start at time 0.

        Args:
            hop_us: step between estimates [µs].
            width: sensor columns [px].
            height: sensor rows [px].
        """
        self._width, self._height = width, height
        self._hops = HopBuffer(hop_us, width=width, height=height)

    def push(self, events: Events) -> list[MotionEstimate]:
        """Take the next events of the stream; see `Detector.push`.

        Raises:
            EventError: not a sorted stream of `EVENT_DTYPE` from this sensor.
            EventOrderError: the first event is older than what was passed or advanced to before.
        """
        return [self._estimate(*hop) for hop in self._hops.push(events)]

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Learn that every event before `t_us` was passed; see `Detector.advance`.

        Raises:
            EventOrderError: `t_us` is before what was passed or advanced to before, or is no whole
                number.
        """
        return [self._estimate(*hop) for hop in self._hops.advance(t_us)]

    @abstractmethod
    def _estimate(self, end_us: int, events: Events) -> MotionEstimate:
        """What there is to say at the end of a hop [µs], of its events and all before."""


def check_whole_hops(hop_us: int, **times_us: int) -> None:
    """Refuse times that hops do not fill.

    Args:
        hop_us: length of a hop [µs].
        times_us: what has to be a whole multiple of it, by name [µs].

    Raises:
        DetectorConfigError: one of them is not.
    """
    for name, value in times_us.items():
        if value % hop_us:
            raise DetectorConfigError(
                f"{name} is {value} µs, no multiple of hop_us = {hop_us} µs; allowed are whole "
                "multiples; choose a hop that divides it"
            )
