"""A fixed latency between the moment an event is read and its time stamp."""

from __future__ import annotations

import numpy as np

from emulator.readout.event_keys import LOW_BITS, TIME_SHIFT, Keys
from emulator.readout.stats import ReadoutStats


class FixedLatency:
    """Stamps events a fixed time after they are read; the whole readout of an unlimited bus.

    Args:
        latency_us: time from the moment an event is read until its time stamp [µs].
    """

    def __init__(self, latency_us: int):
        self._latency_us = latency_us
        self._late: Keys = np.empty(0, np.int64)

    @property
    def waiting(self) -> int:
        """Number of events that are read, with time stamps in a later step."""
        return self._late.size

    def read_out(self, keys: Keys, *, from_us: int, to_us: int) -> tuple[Keys, ReadoutStats]:
        """Read each event of one step at the time at which its pixel fires.

        Args:
            keys: (n,) events of the step, sorted.
            from_us: start of the step [µs from the first sample].
            to_us: end of the step [µs from the first sample].

        Returns:
            Events whose time stamps lie in the step, sorted; and counts of all events.
        """
        stamped = self.stamp(keys, to_us - from_us)
        longest_us = self._latency_us if stamped.size else 0
        return stamped, ReadoutStats(
            offered=keys.size, waiting=self.waiting, delay_max_us=longest_us
        )

    def stamp(self, read: Keys, step_us: int) -> Keys:
        """Add the latency to the times of events that were read in one step.

        Events whose time stamps lie after the step are kept for later steps.

        Args:
            read: (n,) events, sorted by the time at which they were read.
            step_us: duration of the step [µs].

        Returns:
            Events whose time stamps lie in the step, sorted.
        """
        if self._latency_us == 0:
            return read
        end = (step_us << TIME_SHIFT) | LOW_BITS
        step, latency = step_us << TIME_SHIFT, self._latency_us << TIME_SHIFT
        old = int(np.searchsorted(self._late, end, "right"))
        new = int(np.searchsorted(read, end - latency, "right"))
        stamped = np.concatenate((self._late[:old], read[:new] + latency))
        # The step is subtracted first: a sum beyond 30 bits of microseconds would overflow.
        self._late = np.concatenate((self._late[old:] - step, read[new:] - step + latency))
        return stamped
