"""The parameters of the readout, each with its source, or marked as assumed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from emulator.errors import SensorConfigError
from flybench.checks import Range, check_ranges, member

UNLIMITED_HZ = 1e12
"""Number of words per second from which on the bus counts as unlimited."""

_RANGES = {
    "limit_hz": Range(1.0, UNLIMITED_HZ, remedy="Use 1e12 for an unlimited bus."),
    "line_words": Range(0, 1000, remedy="Give a whole number of words, such as 2."),
    "latency_us": Range(0, 1_000_000, remedy="Give whole microseconds, such as 1."),
    "scan_period_us": Range(1, 1_000_000, remedy="Give whole microseconds, such as 194."),
}


class ReadoutKind(StrEnum):
    """How a chip reads its events out.

    Attributes:
        ROW_ARBITER: the pixels request, and a tree of arbiters grants one row after another
            (DVS128, DAVIS, Prophesee's chips).
        ROUND_ROBIN: the same bus, but the rows are granted in their order, each after the one above
            it (flybench's arbiter until November 2026, for comparisons; no real chip is known).
        SCAN: the chip reads the whole array at a fixed period (Samsung's chips, as in the
            DVXplorer).
    """

    ROW_ARBITER = "row_arbiter"
    ROUND_ROBIN = "round_robin"
    SCAN = "scan"


class Lines(StrEnum):
    """Which lines of the image are the rows of the chip that its arbiter chooses between."""

    ROWS = "rows"
    COLUMNS = "columns"


@dataclass(frozen=True, kw_only=True)
class ReadoutConfig:
    """The readout of a sensor; the defaults are those of the DAVIS346.

    Attributes:
        kind: how the events are read out.
        lines: which lines of the image the arbiter chooses between. A scan does not use it. In a
            recording of a DAVIS346 at 4 Mev/s the order of the columns is that of a tree of
            arbiters, and that of the rows is not (docs/explanation/readout.md). Its chip thus lies
            on its side; the driver exchanges x and y if the camera says so (libcaer, "invertXY").
        limit_hz: words per second on the bus [Hz]: one word for each event, and `line_words` for
            each line that is read (the maker's documentation: about 12 million events per second).
            A scan does not use it.
        line_words: time to choose a line and to send its address, in words. In a recording of a
            DAVIS346 whose bus is busy all the time, a line with one event takes 0.243 µs: 2.9 words
            of 1/12 µs, of which the event is one. A scan does not use it.
        latency_us: time from the moment an event is read until its time stamp [µs] (assumed: less
            than 1).
        scan_period_us: period of the scan [µs]; the row arbiter does not use it. The default is
            that of the DVXplorer without events: 640 columns of 15 cycles at 50 MHz, and 2 µs
            between scans (libcaer's defaults). The scan of the real chip takes longer with more
            events, up to 0.85 ms (dv-processing); here it is constant (assumed).

    Raises:
        SensorConfigError: a value is outside its range.
    """

    kind: ReadoutKind = ReadoutKind.ROW_ARBITER
    lines: Lines = Lines.COLUMNS
    limit_hz: float = 12e6
    line_words: int = 2
    latency_us: int = 0
    scan_period_us: int = 194

    def __post_init__(self) -> None:
        kind = member(ReadoutKind, "kind", self.kind, SensorConfigError)
        object.__setattr__(self, "kind", kind)
        lines = member(Lines, "lines", self.lines, SensorConfigError)
        object.__setattr__(self, "lines", lines)
        check_ranges(self, _RANGES, SensorConfigError)


UNLIMITED = ReadoutConfig(limit_hz=UNLIMITED_HZ)
"""A readout that passes every event on at once."""
