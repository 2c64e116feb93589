"""All statistics of one recording."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from flybench.events import Events
from flybench.memory import count_memory
from formats import Chunk
from scenarios.event_statistics.interval_histogram import I64, quantile_us
from scenarios.event_statistics.noise import MeanFrame, NoiseClass, noise_classes
from scenarios.event_statistics.pixel_history import PixelHistory
from scenarios.event_statistics.quiet_pixels import SimultaneousPairs
from scenarios.event_statistics.readout_order import ReadoutOrder, ReadoutShares

FIRST_PERCENTILE = 0.01
_BYTES_PER_PX = 150
"""Memory for a pixel of the sensor, with the result (measured: 147)."""


@dataclass(frozen=True, eq=False)
class RecordingStatistics:
    """Statistics of a recording; a share or mean of nothing is None.

    Attributes:
        events: number of events.
        span_us: time from the first event to the last, at least 1 [µs].
        pixels: number of pixels of the sensor.
        frames: number of APS frames that give the brightness.
        on_share: share of ON events.
        with_predecessor: share of events that have a predecessor of their polarity within 30 ms.
        alternation: share of events whose polarity is not that of the pixel's event before.
        quiet_alternation: the same, at quiet pixels only.
        quiet_share: share of pixels that are quiet.
        runs: (2, 256) number of runs by length: those that are no edges, and edges.
        intervals: (2, BINS) histogram of intervals: same polarity, other polarity.
        noise: noise of all quiet pixels, and then by brightness if there are frames.
        readout: order of rows, at each class of event rates.
    """

    events: int
    span_us: int
    pixels: int
    frames: int
    on_share: float | None
    with_predecessor: float | None
    alternation: float | None
    quiet_alternation: float | None
    quiet_share: float
    runs: I64
    intervals: I64
    noise: tuple[NoiseClass, ...]
    readout: tuple[ReadoutShares, ...]

    @property
    def rate_hz(self) -> float:
        """Mean rate of events per pixel [Hz]."""
        return self.events / (self.pixels * self.span_us * 1e-6)

    @property
    def edges(self) -> int:
        """Number of edges, counted at each pixel."""
        return int(self.runs[1].sum())

    @property
    def events_an_edge(self) -> float | None:
        """Mean number of events a pixel and edge."""
        edges = self.runs[1]
        return _share(int((edges * np.arange(edges.size)).sum()), int(edges.sum()))

    @property
    def single_event_edges(self) -> float | None:
        """Share of edges that give a pixel one event only."""
        return _share(int(self.runs[1, 1]), self.edges)

    def interval_us(self, share: float) -> float | None:
        """Return the interval below which a share of the pixels' intervals lies [µs]."""
        return quantile_us(self.intervals.sum(axis=0), share)


class StatisticsCollector:
    """Collects the statistics of a recording in blocks; memory depends on the sensor only."""

    def __init__(self, *, width: int, height: int) -> None:
        """Allocate the counters.

        Args:
            width: columns of the sensor [px].
            height: rows of the sensor [px].

        Raises:
            MemoryBudgetError: the counters need more memory than the budget allows.
        """
        what = f"A comparison of recordings of {width}×{height} px"
        count_memory(self, what, _BYTES_PER_PX * width * height)
        self._history = PixelHistory(width=width, height=height)
        self._pairs = SimultaneousPairs(width=width, height=height)
        self._order = ReadoutOrder()
        self._frame = MeanFrame(width=width, height=height)
        self._first_us, self._last_us = 0, 0
        self._events = 0

    def add(self, chunk: Chunk) -> None:
        """Include a section of the recording."""
        self._frame.add(chunk.frames)
        if chunk.events.size:
            self._add_events(chunk.events)

    def _add_events(self, events: Events) -> None:
        if not self._events:
            self._first_us = int(events["t"][0])
        self._last_us = int(events["t"][-1])
        self._events += events.size
        self._history.add(events)
        self._pairs.add(events)
        self._order.add(events)

    def result(self) -> RecordingStatistics:
        """Return the statistics of what has been added."""
        history, span_us = self._history, max(1, self._last_us - self._first_us)
        counts, changes = history.counts, history.changes
        totals = counts.sum(axis=0)
        pairs = np.maximum(totals - 1, 0)
        quiet = self._pairs.quiet_pixels(span_us)
        return RecordingStatistics(
            events=self._events,
            span_us=span_us,
            pixels=totals.size,
            frames=self._frame.frames,
            on_share=_share(int(counts[1].sum()), self._events),
            with_predecessor=_share(history.with_predecessor, self._events),
            alternation=_share(int(changes.sum()), int(pairs.sum())),
            quiet_alternation=_share(int(changes[quiet].sum()), int(pairs[quiet].sum())),
            quiet_share=float(quiet.mean()),
            runs=history.runs,
            intervals=history.intervals.copy(),
            noise=noise_classes(counts, quiet, self._frame.brightness(), span_us),
            readout=self._order.shares(),
        )


def statistics_of(chunks: Iterable[Chunk], *, width: int, height: int) -> RecordingStatistics:
    """Return the statistics of a recording, read once, in constant memory.

    Args:
        chunks: sections of the recording, in order of time.
        width: columns of the sensor [px].
        height: rows of the sensor [px].
    """
    collector = StatisticsCollector(width=width, height=height)
    for chunk in chunks:
        collector.add(chunk)
    return collector.result()


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None
