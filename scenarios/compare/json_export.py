"""The JSON document of `flybench compare`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from formats import EventFile
from scenarios.compare.compared import Compared
from scenarios.event_statistics.interval_histogram import I64, bin_edges_us
from scenarios.event_statistics.pixel_history import COINCIDENCE_US, PREDECESSOR_US
from scenarios.event_statistics.recording_statistics import RecordingStatistics


def comparison_dict(
    files: tuple[EventFile, EventFile],
    statistics: tuple[RecordingStatistics, RecordingStatistics],
    rows: Sequence[Compared],
) -> dict[str, Any]:
    """Return the whole comparison as plain values.

    Args:
        files: the recordings, read to their ends.
        statistics: their statistics.
        rows: the compared statistics.
    """
    return {
        "comparison": [asdict(row) for row in rows],
        "a": _recording(files[0], statistics[0]),
        "b": _recording(files[1], statistics[1]),
        "predecessor_us": PREDECESSOR_US,
        "coincidence_us": COINCIDENCE_US,
    }


def _recording(file: EventFile, found: RecordingStatistics) -> dict[str, Any]:
    return {
        "file": str(file.path),
        "format": file.format,
        "width": file.width,
        "height": file.height,
        "sorted_events": file.sorted_events,
        "dropped_events": file.dropped_events,
        "events": found.events,
        "span_us": found.span_us,
        "frames": found.frames,
        "quiet_share": found.quiet_share,
        "edges": found.edges,
        "edges_by_events": _without_tail(found.runs[1]),
        "other_runs_by_events": _without_tail(found.runs[0]),
        "intervals_us": {
            "same_polarity": _histogram(found.intervals[0]),
            "other_polarity": _histogram(found.intervals[1]),
        },
        "noise": [
            asdict(noise) | {"on_hz": noise.on_hz, "off_hz": noise.off_hz} for noise in found.noise
        ],
        "readout": [asdict(order) for order in found.readout],
    }


def _without_tail(counts: I64) -> list[int]:
    """Return counts up to the last that is not 0; the index is the number of events."""
    return [int(count) for count in np.trim_zeros(counts, "b")]


def _histogram(counts: I64) -> list[list[int]]:
    """Return lower edge, upper edge (exclusive) and count of each bin that is not empty."""
    edges = bin_edges_us()
    return [[int(edges[k]), int(edges[k + 1]), int(counts[k])] for k in np.flatnonzero(counts)]
