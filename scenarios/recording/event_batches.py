"""Events gathered into whole milliseconds, the rows that a recording shows them in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flybench.events import Cause, Events, joined

BATCH_US = 1_000
"""One row a millisecond: a row an event costs five times the space and the time (measured)."""

I64 = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class EventBatches:
    """Events of whole milliseconds, each batch with one event or more.

    Attributes:
        t_us: (batches,) end of each millisecond, by which all of its events have happened [µs].
        lengths: (batches,) events in each.
        positions_px: (events, 2) float32, middles of the pixels; x right, y down.
        class_ids: (events,) uint16, see `class_id`.
        on, off, noise: (batches,) ON and OFF events, and those of either that noise made.
    """

    t_us: I64
    lengths: I64
    positions_px: npt.NDArray[np.float32]
    class_ids: npt.NDArray[np.uint16]
    on: I64
    off: I64
    noise: I64


def class_id(cause: int, *, on: bool) -> int:
    """Number of a polarity and cause: 2·cause + polarity, so signal is 0 for OFF and 1 for ON."""
    return 2 * cause + on


def batch(events: Events, causes: npt.NDArray[np.uint8]) -> EventBatches:
    """Cut a sorted stream into milliseconds.

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
    """How many are true from each start to the next."""
    if not starts.size:
        return np.empty(0, np.int64)
    return np.add.reduceat(flags, starts, dtype=np.int64)


class EventBuffer:
    """Keeps events until their millisecond is complete and enough of them have come together."""

    def __init__(self, *, enough: int = 65_536) -> None:
        """Start empty.

        Args:
            enough: events that are worth a chunk in the file (assumed: some 1 MB).
        """
        self._enough = enough
        self._events: list[Events] = []
        self._causes: list[npt.NDArray[np.uint8]] = []
        self._count = 0

    def push(
        self, events: Events, causes: npt.NDArray[np.uint8] | None = None
    ) -> EventBatches | None:
        """Take the next events of the stream.

        Args:
            events: (n,) of `EVENT_DTYPE`, sorted by t, none before those passed earlier.
            causes: (n,) the `Cause` of each; None: all are the signal's.

        Returns:
            Batches of the milliseconds that are over, once there are enough events.
        """
        self._events.append(events)
        self._causes.append(np.zeros(events.size, np.uint8) if causes is None else causes)
        self._count += events.size
        if self._count < self._enough:
            return None
        return self._take(whole=True)

    def flush(self) -> EventBatches | None:
        """Batches of all that is left."""
        return self._take(whole=False) if self._count else None

    def _take(self, *, whole: bool) -> EventBatches | None:
        events, causes = joined(self._events), np.concatenate(self._causes)
        last_us = int(events["t"][-1])
        until = (
            np.searchsorted(events["t"], last_us // BATCH_US * BATCH_US) if whole else events.size
        )
        self._events, self._causes = [events[until:].copy()], [causes[until:].copy()]
        self._count = events.size - int(until)
        return batch(events[:until], causes[:until]) if until else None
