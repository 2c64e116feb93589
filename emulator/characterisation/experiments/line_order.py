"""The order in which the arbiter reads the lines: a tree leaves traces, a sweep leaves others.

All measures take a time stamp's lines as a set, because the order of events with the same time
stamp need not be that of the readout. They are therefore the same for recordings of real cameras.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    Frame,
    bench_sensor,
    chip_luminance,
    record,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from emulator.readout.config import UNLIMITED_HZ, Lines, ReadoutKind
from flybench.events import Events

WIDTH, HEIGHT = 346, 260
"""Size of the array: that of the DAVIS346, whose recording is beside the figures."""
CHIP_LUX = 2000.0
"""Illuminance on the chip: bright enough for the full bandwidth and hardly any noise [lux]."""
SWING = 3.0
"""Peak-to-peak amplitude of the flicker [ln units of luminance]: many times both thresholds, so
that few events are missing where the light turns."""
LOADS = (0.1, 0.2, 0.3, 0.4, 0.46, 0.54, 0.65, 0.8)
"""Events that the pixels generate over words of the bus, approximately."""
RECORDED, HIGHER = 4.15 / 12.0, 5.4 / 12.0
"""Events per word of the bus at which the table gives the figures: those of the recording of a
DAVIS346 (4.15 Mev/s), and more."""
_EVENTS = 150_000
"""Approximate number of events at each load."""
_STEPS = 20
"""Steps of a recording; straight lines between its samples stay within 1 % of the sine if it lasts
for less than a cycle."""
_SETTLING = 0.3
"""Share of a recording in which the queue fills, and which is not counted."""


_FIGURES = (
    ("events per line and time stamp", "", "events_per_line", sources.EVENTS_PER_LINE),
    ("lines per time stamp", "", "lines_per_stamp", sources.LINES_PER_STAMP),
    ("time stamps with neighbouring lines", "%", "neighbours", sources.NEIGHBOUR_LINES),
    ("time stamps with lines at most two apart", "%", "near", sources.NEAR_LINES),
    ("moves that go forward", "%", "forward", sources.FORWARD_MOVES),
)
"""Rows of the table: name, unit, attribute of `LineOrder`, and the published figure."""


@dataclass(frozen=True)
class LineOrder:
    """Order of the lines; a share is None if nothing was counted for it.

    Attributes:
        rate_hz: events per second [Hz].
        lines_per_stamp: number of lines in a time stamp, mean.
        events_per_line: number of events of a line in a time stamp, mean.
        neighbours: share of the time stamps with several lines in which two of them are adjacent.
        near: share of those in which two lines are at most two apart.
        forward: share of the time stamps whose mean line is higher than that of the microsecond
            before, among those where it differs; 0.5 without a sweep.
    """

    rate_hz: float
    lines_per_stamp: float
    events_per_line: float
    neighbours: float | None
    near: float | None
    forward: float | None


def measure_order(events: Events, lines: Lines) -> LineOrder | None:
    """Measure the order of the lines in a recording; None if it has fewer than two time stamps.

    Args:
        events: sorted by t.
        lines: the lines that the arbiter of the camera chooses between.
    """
    times, stamp = np.unique(events["t"], return_inverse=True)
    if times.size < 2:
        return None
    line = events["x" if lines is Lines.COLUMNS else "y"].astype(np.int64)
    read = np.unique((stamp << 16) | line)
    stamp, line = read >> 16, read & 0xFFFF
    number = np.bincount(stamp)
    distance = np.where(np.diff(stamp) == 0, np.diff(line), 1 << 16)
    closest = np.full(times.size, 1 << 16)
    np.minimum.at(closest, stamp[1:], distance)
    several = closest[number > 1]
    move = np.diff(np.bincount(stamp, line) / number)[np.diff(times) == 1]
    return LineOrder(
        rate_hz=1e6 * events.size / float(times[-1] - times[0] + 1),
        lines_per_stamp=read.size / times.size,
        events_per_line=events.size / read.size,
        neighbours=_share(several <= 1),
        near=_share(several <= 2),
        forward=_share(move[move != 0.0] > 0.0),
    )


def measure_load(config: SensorConfig, *, rate_hz: float, seed: int) -> LineOrder | None:
    """Measure the order of the lines if all pixels flicker, each with its own phase.

    Args:
        config: configuration of the sensor; its size is replaced.
        rate_hz: approximate number of events that all pixels together generate per second [Hz].
        seed: seed of the sensor and of the phases.

    Returns:
        The order of the lines; None without events.
    """
    bench = bench_sensor(config, width=WIDTH, height=HEIGHT)
    samples = _flicker(bench, rate_hz, seed)
    events = record(replace(bench, readout=config.readout), samples, seed=seed).events
    settled = events[events["t"] > _SETTLING * samples[-1][0]]
    return measure_order(settled, config.readout.lines)


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on the order of the lines."""
    readout = config.readout
    limited = readout.kind is not ReadoutKind.SCAN and readout.limit_hz < UNLIMITED_HZ
    rates = [share * readout.limit_hz for share in LOADS] if limited else []
    found = [measure_load(config, rate_hz=rate_hz, seed=seed) for rate_hz in rates]
    orders = [order for order in found if order is not None]
    return Section(
        "Order of the readout",
        f"{WIDTH}×{HEIGHT} pixels flicker by {math.exp(SWING):.1f} to 1, each with its own phase, "
        f"at rising frequencies. The arbiter chooses between the {readout.lines} of the image. The "
        "lines of a time stamp are taken as a set. A tree of arbiters serves neighbours together, "
        "and moves forward and back; a readout in turn moves forward. The published figures are "
        "those of a recording with flickering lamps; they depend on which pixels are busy, and "
        "some of its moves are those of the scene.",
        _quantities(orders, readout.limit_hz, "" if limited else "nothing is arbitrated"),
        [_plot(orders)] if orders else [],
    )


def _quantities(orders: list[LineOrder], limit_hz: float, note: str) -> list[Quantity]:
    """Return the rows of the table, interpolated between the loads."""
    rates = [order.rate_hz for order in orders]
    rows = []
    for share, published in ((RECORDED, True), (HIGHER, False)):
        rate_hz = share * limit_hz
        inside = bool(rates) and rates[0] <= rate_hz <= rates[-1]
        at = f"at {1e-6 * rate_hz:.3g} Mev/s" if limit_hz < UNLIMITED_HZ else "at a high load"
        for name, unit, field, source in _FIGURES:
            values = [scaled(order, field) for order in orders]
            value = float(np.interp(rate_hz, rates, values)) if inside else None
            figure = None if value is None or math.isnan(value) else value
            missing = note or ("" if inside else "the sensor does not reach this rate")
            if inside and figure is None:
                missing = "no time stamp has several lines"
            beside = source if published else None
            rows.append(Quantity(f"{name} {at}", unit, figure, beside, missing))
    return rows


def scaled(order: LineOrder, field: str) -> float:
    """Return a figure of the table: shares in per cent, NaN for None."""
    value = getattr(order, field)
    if value is None:
        return math.nan
    return float(value) if field in ("events_per_line", "lines_per_stamp") else 100.0 * value


def _share(found: npt.NDArray[np.bool_]) -> float | None:
    return float(found.mean()) if found.size else None


def _flicker(config: SensorConfig, rate_hz: float, seed: int) -> list[tuple[int, Frame]]:
    """Return luminance samples of pixels that flicker out of step, for about `_EVENTS` events."""
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, (HEIGHT, WIDTH))
    per_cycle = WIDTH * HEIGHT * SWING * (1.0 / config.theta_on + 1.0 / config.theta_off)
    flicker_hz = rate_hz / per_cycle
    step_us = max(1, round(1e6 * _EVENTS / rate_hz / _STEPS))
    base = chip_luminance(config, CHIP_LUX)
    samples = []
    for k in range(_STEPS + 1):
        wave = np.sin(2.0 * math.pi * flicker_hz * k * step_us * 1e-6 + phase)
        samples.append((k * step_us, np.asarray(base * np.exp(0.5 * SWING * wave), np.float32)))
    return samples


def _plot(orders: list[LineOrder]) -> Plot:
    rates = [1e-6 * order.rate_hz for order in orders]
    return Plot(
        "Order of the lines against output rate",
        "output rate [Mev/s]",
        "share of time stamps or moves [%]",
        [
            series(name, rates, [scaled(order, field) for order in orders], Style.LINE, colour)
            for colour, (name, unit, field, _) in enumerate(_FIGURES)
            if unit == "%"
        ],
        x_log=True,
    )
