"""How alike two event streams of the same scene are: which events have a counterpart, and when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flybench.events import Events

WITHIN_US = (200, 500, 1000, 2000)
"""How near in time a counterpart is to be [µs]."""


@dataclass(frozen=True)
class Match:
    """One stream against a reference.

    Attributes:
        count: excess of events over the reference's, as a share of these.
        found: for each of `WITHIN_US`, share of the reference's events with a counterpart of the
            same pixel and polarity in the stream.
        real: the same of the stream's events in the reference.
        median_us: of the time from an event of the stream to its counterpart, of those that have
            one within the last of `WITHIN_US` [µs]; not a number where none has.
    """

    count: float
    found: tuple[float, ...]
    real: tuple[float, ...]
    median_us: float


def match(events: Events, reference: Events) -> Match:
    """Hold a stream against a reference, event by event.

    Args:
        events: sorted by time.
        reference: likewise, of the same sensor; not empty.
    """
    there, back = nearest_us(events, reference), nearest_us(reference, events)
    paired = there[there <= WITHIN_US[-1]]
    return Match(
        count=events.size / reference.size - 1,
        found=_shares(back),
        real=_shares(there),
        median_us=float(np.median(paired)) if paired.size else float("nan"),
    )


def nearest_us(events: Events, others: Events) -> npt.NDArray[np.float64]:
    """(n,) from each event to the nearest of `others` of its pixel and polarity [µs].

    Infinite where there is none.
    """
    span = int(max(events["t"].max(initial=0), others["t"].max(initial=0))) + 1
    keys, sorted_others = _keys(events, span), np.sort(_keys(others, span))
    ends = np.full(1, np.iinfo(np.int64).max // 2)
    padded = np.concatenate([-ends, sorted_others, ends])
    after = np.searchsorted(padded, keys)
    distance = np.full(keys.size, np.inf)
    for neighbour in (padded[after - 1], padded[after]):
        alike = neighbour // span == keys // span
        distance = np.where(alike, np.minimum(distance, np.abs(neighbour - keys)), distance)
    return distance


def _keys(events: Events, span: int) -> npt.NDArray[np.int64]:
    """(n,) numbers that sort by pixel and polarity, then by time."""
    pixel = (events["y"].astype(np.int64) << 16) + events["x"]
    return np.asarray((2 * pixel + events["p"]) * span + events["t"])


def _shares(distance_us: npt.NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(float((distance_us <= limit).mean()) for limit in WITHIN_US)
