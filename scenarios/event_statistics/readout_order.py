"""Order in which a camera reads its rows: rows of a time stamp, and steps from row to row.

The order depends on the load of the readout. Every millisecond therefore belongs to a class of
event rates, and the counts are kept for each class.

Of events that share a time stamp, the order in the file need not be that of the readout. Steps from
row to row are therefore taken only between successive time stamps of one row each.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.events import Events
from flybench.kernels import compiled, inlined

LOAD_EDGES_MEV_S = (0.0, 0.5, 1.0, 2.0, 4.0, 8.0)
"""Lower edges of the classes of event rates [Mev/s]."""
_MS_US = 1000
STAMPS, ONE_ROW, CONTINUED, STEPS, TO_NEIGHBOUR, DOWN = range(6)
"""Columns of the counts: time stamps; those with events of one row only; those of the same row as
the time stamp before or after; steps to another row; steps to the next row; steps downwards."""
_MS, _MS_EVENTS, _T, _ROW, _ROW_BEFORE, _JOINED = range(6)
_MANY, _NO_ROW = -2, -1

I64 = npt.NDArray[np.int64]


@dataclass(frozen=True)
class ReadoutShares:
    """Order of the rows at one load; a share is None if nothing was counted for it.

    Attributes:
        from_mev_s: lower edge of the event rates [Mev/s].
        stamps: number of time stamps.
        steps: number of steps from row to row.
        one_row: share of time stamps with events of one row only.
        continued: share of time stamps of the same single row as the time stamp before or after.
        to_neighbour: share of steps that go to a neighbouring row.
        down: share of steps that go downwards.
    """

    from_mev_s: float
    stamps: int
    steps: int
    one_row: float | None
    continued: float | None
    to_neighbour: float | None
    down: float | None


class ReadoutOrder:
    """Counts of the order of rows, updated block by block."""

    def __init__(self) -> None:
        self._counts = np.zeros((len(LOAD_EDGES_MEV_S), 6), np.int64)
        self._millisecond = np.zeros(6, np.int64)
        self._state = _first_state()

    def add(self, events: Events) -> None:
        """Include events, sorted by time and none older than those before."""
        _add(events, self._state, self._millisecond, self._counts)

    def shares(self) -> tuple[ReadoutShares, ...]:
        """Return the shares at each class of event rates, the lowest first."""
        counts, state = self._counts.copy(), self._state.copy()
        millisecond = self._millisecond.copy()
        if state[_ROW] != _NO_ROW:
            _end_stamp(state, millisecond)
            _end_millisecond(state, millisecond, counts)
        return tuple(map(_shares, LOAD_EDGES_MEV_S, counts))


def _first_state() -> I64:
    state = np.zeros(6, np.int64)
    state[_ROW] = state[_ROW_BEFORE] = _NO_ROW
    return state


def _shares(from_mev_s: float, counts: I64) -> ReadoutShares:
    stamps, one_row, continued, steps, to_neighbour, down = counts.tolist()
    return ReadoutShares(
        from_mev_s=from_mev_s,
        stamps=stamps,
        steps=steps,
        one_row=one_row / stamps if stamps else None,
        continued=continued / stamps if stamps else None,
        to_neighbour=to_neighbour / steps if steps else None,
        down=down / steps if steps else None,
    )


@compiled
def _add(events: Any, state: Any, millisecond: Any, counts: Any) -> None:
    for n in range(events.size):
        event = events[n]
        t, row = event.t, event.y
        if t == state[_T] and state[_ROW] != _NO_ROW:
            if row != state[_ROW]:
                state[_ROW] = _MANY
        else:
            if state[_ROW] != _NO_ROW:
                _end_stamp(state, millisecond)
            if t // _MS_US != state[_MS]:
                _end_millisecond(state, millisecond, counts)
                state[_MS] = t // _MS_US
            state[_T], state[_ROW] = t, row
        state[_MS_EVENTS] += 1


@inlined
def _end_stamp(state: Any, counts: Any) -> None:
    """Count a time stamp, and the step from the one before if both have one row."""
    row, before = state[_ROW], state[_ROW_BEFORE]
    counts[STAMPS] += 1
    counts[ONE_ROW] += row >= 0
    joined = row >= 0 and row == before
    if joined:
        counts[CONTINUED] += 1 if state[_JOINED] else 2  # the one before is counted here, too
    elif row >= 0 and before >= 0:
        counts[STEPS] += 1
        counts[TO_NEIGHBOUR] += abs(row - before) == 1
        counts[DOWN] += row > before
    state[_JOINED], state[_ROW_BEFORE] = joined, row


@inlined
def _end_millisecond(state: Any, millisecond: Any, counts: Any) -> None:
    """Add the counts of a millisecond to the class of its event rate."""
    rate_mev_s = state[_MS_EVENTS] / _MS_US
    load = 0
    while load + 1 < len(LOAD_EDGES_MEV_S) and rate_mev_s >= LOAD_EDGES_MEV_S[load + 1]:
        load += 1
    counts[load] += millisecond
    millisecond[:] = 0
    state[_MS_EVENTS] = 0
