"""Detectors that look at windows of whole hops, and the buffer that cuts a stream into hops.

A hop is the step from one estimate to the next.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque

import numpy as np

from detector.errors import DetectorConfigError
from detector.estimate import MotionEstimate
from detector.event_checks import (
    check_chunk,
    check_estimates,
    check_order,
    check_pause,
    checked_time,
)
from flybench.events import Events, concatenate_events, empty_events
from flybench.memory import count_memory

QUIET_LIMIT_US = 60_000_000
"""Time after the last event at which hops stop [µs]; the default of `FlyConfig.quiet_limit_us`."""

_EVENT_BYTES = 100
"""Memory per event of a window: its copies, and the fits of planes to all (estimated) [bytes]."""


class HopBuffer:
    """Collects events and returns those of each hop, in order, when the hop is complete.

    Hops begin at whole multiples of their length. They stop `QUIET_LIMIT_US` after the last event
    and resume with the hop of the next event. If the first event of a stream is later than
    `QUIET_LIMIT_US`, hops start with that event, and an earlier `advance` beyond the limit returns
    nothing.
    """

    def __init__(self, hop_us: int, *, width: int, height: int, window_hops: int = 1) -> None:
        """Start at time 0.

        Args:
            hop_us: length of a hop [µs].
            width: sensor columns [px].
            height: sensor rows [px].
            window_hops: number of hops whose events the detector remembers.

        Raises:
            MemoryBudgetError: the hop is so short that the estimates of a pause do not fit.
        """
        check_pause(hop_us, QUIET_LIMIT_US)
        self._hop_us, self._width, self._height = hop_us, width, height
        self._numbers = deque([0] * window_hops, maxlen=window_hops)
        self._hop = 0
        self._now_us = self._last_event_us = 0
        self._has_events = False
        self._pending: list[Events] = []

    def push(self, events: Events) -> list[tuple[int, Events]]:
        """Add the next events.

        Returns:
            End [µs] and events of each hop that ended at or before the last event.

        Raises:
            EventError: the chunk is not a sorted stream of `EVENT_DTYPE` from this sensor.
            EventOrderError: the first event is before an event or a time that was passed before.
            MemoryBudgetError: the events of a window, or the estimates of this call, are too many
                for the memory budget.
        """
        check_chunk(events, width=self._width, height=self._height, now_us=self._now_us)
        if events.size:
            check_estimates(
                events["t"],
                now_us=self._now_us,
                hop_us=self._hop_us,
                quiet_limit_us=QUIET_LIMIT_US,
            )
        complete: list[tuple[int, Events]] = []
        taken = 0
        while taken < events.size:
            first_us = int(events["t"][taken])
            self._skip_to_late_start(first_us)
            complete += self._complete_hops(first_us)
            self._has_events = True
            self._skip_to(first_us)
            cut = int(np.searchsorted(events["t"], (self._hop + 1) * self._hop_us))
            self._count(cut - taken)
            self._pending.append(concatenate_events([events[taken:cut]]))
            self._last_event_us = self._now_us = int(events["t"][cut - 1])
            taken = cut
        return complete

    def advance(self, t_us: int) -> list[tuple[int, Events]]:
        """Declare that every event before `t_us` has been passed.

        Returns:
            End [µs] and events of each hop that ended at or before `t_us`.

        Raises:
            EventOrderError: `t_us` is before an event or a time that was passed before, or is not a
                whole number.
        """
        t_us = checked_time(t_us)
        check_order(t_us, self._now_us)
        self._now_us = t_us
        self._skip_to_late_start(t_us)
        return self._complete_hops(t_us)

    def _skip_to_late_start(self, t_us: int) -> None:
        """Skip to the hop of a late time if there was no event yet."""
        if not self._has_events and t_us > QUIET_LIMIT_US:
            self._skip_to(t_us)

    def _complete_hops(self, t_us: int) -> list[tuple[int, Events]]:
        """Return the hops that end at or before a time and within the quiet limit."""
        complete = []
        last_us = min(t_us, self._last_event_us + QUIET_LIMIT_US)
        while (end_us := (self._hop + 1) * self._hop_us) <= last_us:
            parts = self._pending or [empty_events()]
            self._numbers.append(sum(part.size for part in parts))
            complete.append((end_us, parts[0] if len(parts) == 1 else concatenate_events(parts)))
            self._pending = []
            self._hop += 1
        return complete

    def _count(self, new: int) -> None:
        """Count the memory of the window with `new` more events, before they are copied."""
        number = sum(self._numbers) + sum(part.size for part in self._pending) + new
        count_memory(self, f"A window of {number} events", number * _EVENT_BYTES)

    def _skip_to(self, t_us: int) -> None:
        self._hop = max(self._hop, t_us // self._hop_us)


class WindowedDetector(ABC):
    """Base class of detectors that look at windows of whole hops."""

    def __init__(self, hop_us: int, window_us: int, *, width: int, height: int) -> None:
        """Start at time 0.

        Args:
            hop_us: step between estimates [µs].
            window_us: span of the events that the detector remembers, a multiple of the hop [µs].
            width: sensor columns [px].
            height: sensor rows [px].

        Raises:
            MemoryBudgetError: the hop is so short that the estimates of a pause do not fit.
        """
        self._width, self._height = width, height
        hops = window_us // hop_us
        self._hops = HopBuffer(hop_us, width=width, height=height, window_hops=hops)

    def push(self, events: Events) -> list[MotionEstimate]:
        """Process the next events of the stream; see `Detector.push`.

        Raises:
            EventError: the chunk is not a sorted stream of `EVENT_DTYPE` from this sensor.
            EventOrderError: the first event is before an event or a time that was passed before.
        """
        return [self._estimate(*hop) for hop in self._hops.push(events)]

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Declare that every event before `t_us` has been passed; see `Detector.advance`.

        Raises:
            EventOrderError: `t_us` is before an event or a time that was passed before, or is not a
                whole number.
        """
        return [self._estimate(*hop) for hop in self._hops.advance(t_us)]

    @abstractmethod
    def _estimate(self, end_us: int, events: Events) -> MotionEstimate:
        """Return the estimate at the end of a hop.

        Args:
            end_us: end of the hop, exclusive [µs].
            events: events of this hop; the detector remembers those of earlier hops.
        """


def check_whole_hops(hop_us: int, **times_us: int) -> None:
    """Refuse times that are not multiples of the hop.

    Args:
        hop_us: length of a hop [µs].
        times_us: times to check, by parameter name [µs].

    Raises:
        DetectorConfigError: a time is not a multiple of `hop_us`.
    """
    for name, value in times_us.items():
        if value % hop_us:
            raise DetectorConfigError(
                f"{name} is {value} µs. Allowed is a multiple of hop_us = {hop_us} µs. Choose a "
                "hop that divides it."
            )
