"""Group events into milliseconds, which are the rows of a recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flybench.events import Cause, Events, concatenate_events

BATCH_US = 1_000
"""Duration of a row; one row per event would take five times the space and time (measured)."""

I64 = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class EventBatches:
    """Events in batches of one millisecond; no batch is empty.

    Attributes:
        t_us: (batches,) end of each millisecond [µs].
        lengths: (batches,) number of events in each batch.
        positions_px: (events, 2) float32, pixel centres; x right, y down.
        class_ids: (events,) uint16, see `class_id`.
        on: (batches,) number of ON events.
        off: (batches,) number of OFF events.
        noise: (batches,) number of noise events of either polarity.
    """

    t_us: I64
    lengths: I64
    positions_px: npt.NDArray[np.float32]
    class_ids: npt.NDArray[np.uint16]
    on: I64
    off: I64
    noise: I64


def class_id(cause: int, *, on: bool) -> int:
    """Return the class 2·cause + polarity of an event; signal events have 0 (OFF) and 1 (ON)."""
    return 2 * cause + on


def batch_events(events: Events, causes: npt.NDArray[np.uint8]) -> EventBatches:
    """Split a sorted stream into milliseconds.

    Args:
        events: (n,) of `EVENT_DTYPE`, sorted by t.
        causes: (n,) the `Cause` of each.
    """
    ends_us, starts, lengths = np.unique(
        events["t"] // BATCH_US * BATCH_US + BATCH_US, return_index=True, return_counts=True
    )
    positions = np.empty((events.size, 2), np.float32)
    positions[:, 0] = events["x"]
    positions[:, 1] = events["y"]
    positions += 0.5
    on = _count(events["p"], starts)
    return EventBatches(
        t_us=ends_us,
        lengths=lengths,
        positions_px=positions,
        class_ids=2 * causes.astype(np.uint16) + events["p"],
        on=on,
        off=lengths - on,
        noise=_count(causes != Cause.SIGNAL, starts),
    )


def _count(flags: npt.NDArray[np.bool_], starts: I64) -> I64:
    """Return the number of true flags from each start to the next."""
    if not starts.size:
        return np.empty(0, np.int64)
    return np.add.reduceat(flags, starts, dtype=np.int64)


class EventBuffer:
    """Buffer that returns complete milliseconds when it holds enough events."""

    def __init__(self, *, chunk_events: int = 65_536) -> None:
        """Create an empty buffer.

        Args:
            chunk_events: number of events to collect for a chunk of the file (assumed: about 1 MB).
        """
        self._chunk_events = chunk_events
        self._events: list[Events] = []
        self._causes: list[npt.NDArray[np.uint8]] = []
        self._count = 0

    def push(
        self, events: Events, causes: npt.NDArray[np.uint8] | None = None
    ) -> EventBatches | None:
        """Add the next events of the stream.

        Args:
            events: (n,) of `EVENT_DTYPE`, sorted by t, none earlier than those added before.
            causes: (n,) `Cause` of each event; None: all are signal.

        Returns:
            Batches of the complete milliseconds if there are enough events, otherwise None.
        """
        self._events.append(events)
        self._causes.append(np.zeros(events.size, np.uint8) if causes is None else causes)
        self._count += events.size
        if self._count < self._chunk_events:
            return None
        return self._take(keep_last=True)

    def flush(self) -> EventBatches | None:
        """Return batches of all remaining events; None if there are none."""
        return self._take(keep_last=False) if self._count else None

    def _take(self, *, keep_last: bool) -> EventBatches | None:
        """Remove and return events; the last millisecond may be incomplete and stay."""
        events, causes = concatenate_events(self._events), np.concatenate(self._causes)
        last_us = int(events["t"][-1])
        until = events.size
        if keep_last:
            until = int(np.searchsorted(events["t"], last_us // BATCH_US * BATCH_US))
        self._events, self._causes = [events[until:].copy()], [causes[until:].copy()]
        self._count = events.size - until
        return batch_events(events[:until], causes[:until]) if until else None
