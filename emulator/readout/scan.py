"""The synchronous scan: the chip reads its whole array at a fixed period.

Samsung's sensor in the DVXplorer freezes all pixels at once ("global hold", on by default in
libcaer), reads the array column by column in groups of pixels, and releases it (Son et al., ISSCC
2017: groups of 8 pixels). All events of one scan get the time stamp of the hold. In recordings of
that sensor, time stamps come in groups about 0.2 ms apart (issue 32 of the dataset EVIMO).

A pixel can hold one event between two scans; what it would fire until it is read is lost. Its
reset starts at the event, not at the scan (assumed).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from emulator.readout.event_keys import LOW_BITS, TIME_SHIFT, Keys
from emulator.readout.latency import FixedLatency
from emulator.readout.stats import ReadoutStats


class Scan:
    """Reads the events of a sensor by a scan of the whole array, step by step.

    Args:
        period_us: period of the scan [µs]; the first sample counts as a scan.
        latency_us: time from a scan to the time stamp of its events [µs].
    """

    def __init__(self, *, period_us: int, latency_us: int):
        self._period_us = period_us
        self._latency_us = latency_us
        self._times_us: npt.NDArray[np.int64] = np.empty(0, np.int64)
        self._lows: Keys = np.empty(0, np.int64)
        self._latency = FixedLatency(latency_us)

    def read_out(self, keys: Keys, *, from_us: int, to_us: int) -> tuple[Keys, ReadoutStats]:
        """Read the events of one step out.

        Args:
            keys: (n,) events of the step, sorted.
            from_us: start of the step [µs from the first sample].
            to_us: end of the step [µs from the first sample].

        Returns:
            Events whose time stamps lie in the step, sorted; and counts of all events.
        """
        times_us = np.concatenate((self._times_us, from_us + (keys >> TIME_SHIFT)))
        lows = np.concatenate((self._lows, keys & LOW_BITS))
        scans = -(-times_us // self._period_us)
        _, kept = np.unique(
            ((scans - from_us // self._period_us) << 30) | (lows >> 3), return_index=True
        )
        stamps_us = scans[kept] * self._period_us
        done = int(np.searchsorted(stamps_us, to_us, "right"))
        self._times_us, self._lows = times_us[kept[done:]], lows[kept[done:]]
        delays_us = stamps_us[:done] - times_us[kept[:done]]
        read = ((stamps_us[:done] - from_us) << TIME_SHIFT) | lows[kept[:done]]
        stamped = self._latency.stamp(read, to_us - from_us)
        return stamped, ReadoutStats(
            offered=keys.size,
            delayed=int(np.count_nonzero(delays_us)),
            dropped=times_us.size - kept.size,
            waiting=self._times_us.size + self._latency.waiting,
            delay_max_us=int(delays_us.max()) + self._latency_us if done else 0,
        )
