"""Match the events of two streams of the same scene, and measure how well they agree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flybench.events import Events

WITHIN_US = (200, 500, 1000, 2000)
"""Tolerances for the time between two matching events [µs]."""


@dataclass(frozen=True)
class Match:
    """Agreement of a stream with a reference stream.

    Two events match if they have the same pixel and polarity, and times within a tolerance.

    Attributes:
        excess: number of events relative to the reference, minus 1.
        recall: share of the reference's events that match an event of the stream, for each
            tolerance in `WITHIN_US`.
        precision: share of the stream's events that match an event of the reference, for each
            tolerance in `WITHIN_US`.
        median_us: median time between matching events [µs], at the largest tolerance; NaN if no
            event matches.
    """

    excess: float
    recall: tuple[float, ...]
    precision: tuple[float, ...]
    median_us: float


def match(events: Events, reference: Events) -> Match:
    """Compare a stream with a reference, event by event.

    Args:
        events: events sorted by time.
        reference: events sorted by time, from the same sensor; not empty.
    """
    to_reference, to_events = nearest_us(events, reference), nearest_us(reference, events)
    matched = to_reference[to_reference <= WITHIN_US[-1]]
    return Match(
        excess=events.size / reference.size - 1,
        recall=_shares(to_events),
        precision=_shares(to_reference),
        median_us=float(np.median(matched)) if matched.size else float("nan"),
    )


def nearest_us(events: Events, others: Events) -> npt.NDArray[np.float64]:
    """Return the time from each event to the nearest of `others` with its pixel and polarity.

    Returns:
        (n,) times [µs]; infinite where there is no such event.
    """
    span = int(max(events["t"].max(initial=0), others["t"].max(initial=0))) + 1
    keys, sorted_others = _keys(events, span), np.sort(_keys(others, span))
    ends = np.full(1, np.iinfo(np.int64).max // 2)
    padded = np.concatenate([-ends, sorted_others, ends])
    after = np.searchsorted(padded, keys)
    distance = np.full(keys.size, np.inf)
    for neighbour in (padded[after - 1], padded[after]):
        same = neighbour // span == keys // span
        distance = np.where(same, np.minimum(distance, np.abs(neighbour - keys)), distance)
    return distance


def _keys(events: Events, span: int) -> npt.NDArray[np.int64]:
    """Return (n,) integers that sort events by pixel and polarity, then by time."""
    pixel = (events["y"].astype(np.int64) << 16) + events["x"]
    return np.asarray((2 * pixel + events["p"]) * span + events["t"])


def _shares(distance_us: npt.NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(float((distance_us <= limit).mean()) for limit in WITHIN_US)
