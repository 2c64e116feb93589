"""The compared statistics, in the order of the table: both values, and their distance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

from scenarios.event_statistics.distances import (
    difference,
    interval_distance,
    log_ratio,
    noise_distance,
)
from scenarios.event_statistics.noise import NoiseClass, brightness_label
from scenarios.event_statistics.readout_order import ReadoutShares
from scenarios.event_statistics.recording_statistics import (
    FIRST_PERCENTILE,
    RecordingStatistics,
)

_MIN_STEPS = 1000
"""Fewest steps from row to row at which the order of rows is compared (assumed: shares are then
known to 0.03 with 95 % confidence)."""


class Measure(StrEnum):
    """How a distance is computed, see `event_statistics.distances`."""

    LOG_RATIO = "|ln(B/A)|"
    DIFFERENCE = "|B − A|"
    WASSERSTEIN = "W₁ of ln"


class Unit(StrEnum):
    """Unit of a statistic, which decides how it is printed."""

    EVENTS = "events"
    SHARE = "share"
    TIME = "µs"
    RATE = "Hz"
    LOG = "ln"
    NONE = ""


@dataclass(frozen=True)
class Compared:
    """One statistic of two recordings.

    Attributes:
        key: name in JSON, the same in every version.
        name: name in the table.
        unit: unit of the values.
        a: value in A; None if A does not tell it.
        b: value in B; None if B does not tell it.
        distance: distance of the two, 0 or more; None if one of them is missing or has too few
            events.
        measure: how the distance is computed.
    """

    key: str
    name: str
    unit: Unit
    a: float | None
    b: float | None
    distance: float | None
    measure: Measure


def compare_statistics(a: RecordingStatistics, b: RecordingStatistics) -> tuple[Compared, ...]:
    """Return every statistic of two recordings with its distance."""
    return (*_polarity_and_edges(a, b), *_intervals(a, b), *_noise(a, b), *_readout(a, b))


def busiest_shared(
    a: RecordingStatistics, b: RecordingStatistics
) -> tuple[ReadoutShares, ReadoutShares] | None:
    """Return the order of rows at the highest event rate that both recordings have long enough."""
    shared = [
        pair
        for pair in zip(a.readout, b.readout, strict=True)
        if min(order.steps for order in pair) >= _MIN_STEPS
    ]
    return shared[-1] if shared else None


def _by_ratio(key: str, name: str, unit: Unit, a: float | None, b: float | None) -> Compared:
    return Compared(key, name, unit, a, b, log_ratio(a, b), Measure.LOG_RATIO)


def _by_difference(key: str, name: str, unit: Unit, a: float | None, b: float | None) -> Compared:
    return Compared(key, name, unit, a, b, difference(a, b), Measure.DIFFERENCE)


def _polarity_and_edges(a: RecordingStatistics, b: RecordingStatistics) -> Iterator[Compared]:
    yield _by_ratio("rate_hz", "events per pixel", Unit.RATE, a.rate_hz, b.rate_hz)
    name, values = "events per pixel and edge", (a.events_an_edge, b.events_an_edge)
    yield _by_ratio("events_an_edge", name, Unit.EVENTS, *values)
    for key, name in (
        ("single_event_edges", "edges with one event"),
        ("with_predecessor", "predecessor within 30 ms"),
        ("on_share", "ON events"),
        ("alternation", "alternation of polarity"),
        ("quiet_alternation", "alternation, quiet pixels"),
    ):
        yield _by_difference(key, name, Unit.SHARE, getattr(a, key), getattr(b, key))


def _intervals(a: RecordingStatistics, b: RecordingStatistics) -> Iterator[Compared]:
    for key, name, share in (
        ("interval_first_percentile_us", "interval, 1st percentile", FIRST_PERCENTILE),
        ("interval_median_us", "interval, median", 0.5),
    ):
        yield _by_ratio(key, name, Unit.TIME, a.interval_us(share), b.interval_us(share))
    distance = interval_distance(a.intervals.sum(axis=0), b.intervals.sum(axis=0))
    name, measure = "interval, distribution", Measure.WASSERSTEIN
    yield Compared("intervals", name, Unit.NONE, None, None, distance, measure)


def _noise(a: RecordingStatistics, b: RecordingStatistics) -> Iterator[Compared]:
    """Yield rate and spread of the noise, of each class of which either has quiet pixels."""
    by_edge = [{noise.from_brightness: noise for noise in s.noise} for s in (a, b)]
    for edge in by_edge[0] | by_edge[1]:
        noise_a, noise_b = (classes.get(edge) for classes in by_edge)
        if edge is None or any(noise and noise.pixels for noise in (noise_a, noise_b)):
            yield from _noise_of_class(edge, noise_a, noise_b)


def _noise_of_class(
    edge: float | None, a: NoiseClass | None, b: NoiseClass | None
) -> Iterator[Compared]:
    where = brightness_label(edge)
    key = "quiet" if edge is None else f"from_{edge:g}"
    distance = noise_distance(a, b) if a and b else None
    yield Compared(
        f"noise_hz.{key}",
        f"noise, {where}",
        Unit.RATE,
        a.rate_hz if a else None,
        b.rate_hz if b else None,
        distance,
        Measure.LOG_RATIO,
    )
    first, second = (noise.spread if noise else None for noise in (a, b))
    far = None if distance is None else difference(first, second)
    name = f"spread, {where}"
    yield Compared(f"noise_spread.{key}", name, Unit.LOG, first, second, far, Measure.DIFFERENCE)


def _readout(a: RecordingStatistics, b: RecordingStatistics) -> Iterator[Compared]:
    """Yield the order of rows at the busiest class that both have; else each at its own busiest."""
    shared = busiest_shared(a, b)
    orders = shared or [_busiest(s) for s in (a, b)]
    for key, name in (
        ("one_row", "stamps of one row"),
        ("continued", "stamps that repeat a row"),
        ("to_neighbour", "row changes to neighbour"),
        ("down", "row changes downwards"),
    ):
        first, second = (getattr(order, key) for order in orders)
        distance = difference(first, second) if shared else None
        measure = Measure.DIFFERENCE
        yield Compared(f"readout.{key}", name, Unit.SHARE, first, second, distance, measure)


def _busiest(statistics: RecordingStatistics) -> ReadoutShares:
    """Return the order of rows at the highest event rate that has a time stamp."""
    return [order for order in statistics.readout if order.stamps][-1]
