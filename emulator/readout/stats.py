"""Counts of what a readout did with the events of one step."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ReadoutStats:
    """What the readout did with the events of one step.

    Attributes:
        offered: events that the pixels fired in the step.
        delayed: events read at least 1 µs after the pixel fired.
        dropped: events lost because their pixel still waited or was held in reset.
        waiting: events carried over to later steps.
        delay_max_us: longest delay of an event that was read, including the latency [µs].
    """

    offered: int = 0
    delayed: int = 0
    dropped: int = 0
    waiting: int = 0
    delay_max_us: int = 0
