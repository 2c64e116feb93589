"""The order of the readout: what a tree of arbiters leaves, and what a sweep leaves."""

from dataclasses import replace

import numpy as np
import pytest

from emulator import Lines, ReadoutConfig, ReadoutKind, SensorConfig, preset
from emulator.characterisation import sources
from emulator.characterisation.experiments.line_order import (
    measure,
    measure_load,
    measure_order,
)
from flybench.events import EVENT_DTYPE

TREE = ReadoutConfig()
SWEEP = ReadoutConfig(kind=ReadoutKind.ROUND_ROBIN)


def forward_moves(readout: ReadoutConfig, rate_hz: float) -> float:
    """Return the share of moves forward, mean of three recordings: it varies by 0.05."""
    shares = []
    for seed in (1, 2, 3):
        order = measure_load(replace(SensorConfig(), readout=readout), rate_hz=rate_hz, seed=seed)
        assert order is not None
        assert order.forward is not None
        shares.append(order.forward)
    return float(np.mean(shares))


def test_the_lines_of_a_time_stamp_are_a_set() -> None:
    events = np.array(
        [
            (10, 7, 0, 1),
            (10, 5, 1, 1),
            (10, 7, 2, 0),
            (10, 6, 3, 0),
            (11, 9, 0, 1),
            (11, 11, 0, 1),
            (12, 3, 0, 1),
            (20, 4, 0, 1),
        ],
        EVENT_DTYPE,
    )
    order = measure_order(events, Lines.COLUMNS)
    assert order is not None
    assert order.lines_per_stamp == 7 / 4
    assert order.events_per_line == 8 / 7
    assert (order.neighbours, order.near) == (0.5, 1.0)
    assert order.forward == 0.5  # from 6 to 10 and to 3; the last stamp is 8 µs later
    assert measure_order(events[:4], Lines.COLUMNS) is None


def test_the_order_does_not_depend_on_that_within_a_time_stamp() -> None:
    rng = np.random.default_rng(1)
    events = np.zeros(2000, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, 600, 2000))
    events["x"], events["y"] = rng.integers(0, 346, 2000), rng.integers(0, 260, 2000)
    sorted_otherwise = np.sort(events, order=["t", "y", "x"])
    for lines in Lines:
        assert measure_order(events, lines) == measure_order(sorted_otherwise, lines)


@pytest.mark.parametrize("lines", list(Lines))
@pytest.mark.parametrize("rate_hz", [4.2e6, 5.4e6, 8.8e6])
def test_the_tree_moves_forward_and_back_and_a_sweep_only_forward(
    lines: Lines, rate_hz: float
) -> None:
    tree = forward_moves(replace(TREE, lines=lines), rate_hz)
    sweep = forward_moves(replace(SWEEP, lines=lines), rate_hz)
    assert tree == pytest.approx(0.5, abs=0.05)
    assert sweep > (0.55 if rate_hz == 4.2e6 else 0.8)


def test_the_order_resembles_that_of_a_real_camera() -> None:
    """The real figures depend on which pixels are busy, so the limits are wide (assumed)."""
    figures = measure(SensorConfig(), seed=1).figures

    def of(name: str) -> float:
        value = figures[f"{name} at 4.15 Mev/s"].measured
        assert value is not None
        return value

    assert of("events per line and time stamp") == pytest.approx(
        sources.EVENTS_PER_LINE.value, abs=0.2
    )
    assert of("lines per time stamp") == pytest.approx(sources.LINES_PER_STAMP.value, abs=0.6)
    neighbours, near = sources.NEIGHBOUR_LINES.value, sources.NEAR_LINES.value
    assert of("time stamps with neighbouring lines") == pytest.approx(neighbours, abs=15)
    assert of("time stamps with lines at most two apart") == pytest.approx(near, abs=15)
    assert of("moves that go forward") == pytest.approx(50, abs=5)


def test_without_an_arbiter_the_table_says_so() -> None:
    for name in ("ideal", "dvxplorer"):
        rows = measure(preset(name), seed=1).quantities
        assert {row.measured for row in rows} == {None}
        assert {row.note for row in rows} == {"nothing is arbitrated"}
