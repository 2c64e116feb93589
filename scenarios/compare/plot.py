"""The figure of `flybench compare`: distributions of both recordings side by side."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from scenarios.compare.compared import Compared
from scenarios.event_statistics.interval_histogram import F64, bin_edges_us
from scenarios.event_statistics.noise import BRIGHTNESS_EDGES, brightness_label
from scenarios.event_statistics.recording_statistics import RecordingStatistics
from scenarios.output.colours import SERIES
from scenarios.output.figures import figure_file, literal

SIZE_IN = (11.0, 6.4)
COLOURS = SERIES[:2]
_MAX_EVENTS = 12
_BINS_A_DECADE = 12
_SHARES = ("on_share", "with_predecessor", "single_event_edges", "alternation", "quiet_alternation")
_LABELS = (
    "ON",
    "predecessor\nin 30 ms",
    "edges of\none event",
    "alternation",
    "alternation,\nquiet",
)
Pair = tuple[RecordingStatistics, RecordingStatistics]


def write_plot(
    png: Path, names: tuple[str, str], statistics: Pair, rows: Sequence[Compared]
) -> None:
    """Draw the figure and write it as PNG.

    Args:
        png: path of the file, in an existing folder.
        names: names of the recordings.
        statistics: their statistics.
        rows: the compared statistics.
    """
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder) / "figure"
        with figure_file(base, SIZE_IN) as figure:
            lines = [Line2D([], [], color=colour, linewidth=4) for colour in COLOURS]
            figure.legend(
                lines, [literal(name) for name in names], loc="outside upper left", ncols=2
            )
            panels = figure.subplots(2, 3).flat
            _draw_intervals(panels[0], statistics)
            _draw_edges(panels[1], statistics)
            _draw_shares(panels[2], statistics)
            _draw_noise(panels[3], statistics)
            _draw_readout(panels[4], statistics)
            _draw_distances(panels[5], rows)
        png.write_bytes(base.with_suffix(".png").read_bytes())


def _draw_intervals(axes: Any, statistics: Pair) -> None:
    edges = np.maximum(bin_edges_us(), 0.5)
    for found, colour in zip(statistics, COLOURS, strict=True):
        low_us, high_us, first_us = (found.interval_us(q) for q in (0.001, 1.0, 0.01))
        if low_us is None or high_us is None or first_us is None:
            continue
        low, high = np.log10(low_us) - 0.1, np.log10(high_us) + 0.1
        coarse = np.logspace(low, high, max(2, int((high - low) * _BINS_A_DECADE)))
        counts = found.intervals.sum(axis=0)
        share = np.diff(np.interp(coarse, edges, _cumulative(counts))) / counts.sum()
        axes.stairs(share / np.diff(np.log10(coarse)), coarse * 1e-3, color=colour)
        axes.axvline(first_us * 1e-3, color=colour, linestyle=":", linewidth=1.0)
    axes.set_xscale("log")
    axes.set_xlabel("interval at a pixel [ms] (dotted: 1st percentile)")
    axes.set_ylabel("share per decade")
    axes.set_title("Intervals")


def _cumulative(counts: Any) -> F64:
    return np.concatenate([[0.0], np.cumsum(counts)])


def _draw_edges(axes: Any, statistics: Pair) -> None:
    for k, (found, colour) in enumerate(zip(statistics, COLOURS, strict=True)):
        counts = found.runs[1]
        shown = np.append(counts[1:_MAX_EVENTS], counts[_MAX_EVENTS:].sum())
        heights = shown / max(1, found.edges)
        axes.bar(np.arange(1, _MAX_EVENTS + 1) + 0.4 * k - 0.2, heights, 0.4, color=colour)
    ticks = [1, *range(2, _MAX_EVENTS, 2), _MAX_EVENTS]
    axes.set_xticks(ticks, [*map(str, ticks[:-1]), f"≥{_MAX_EVENTS}"])
    axes.set_xlabel("events per pixel and edge")
    axes.set_ylabel("share of edges")
    axes.set_title("Edges")


def _draw_shares(axes: Any, statistics: Pair) -> None:
    for k, (found, colour) in enumerate(zip(statistics, COLOURS, strict=True)):
        values = [getattr(found, key) or 0.0 for key in _SHARES]
        axes.barh(np.arange(len(values)) + 0.4 * k - 0.2, values, 0.4, color=colour)
    axes.set_yticks(range(len(_LABELS)), _LABELS)
    axes.invert_yaxis()
    axes.set_xlim(0, 1)
    axes.set_xlabel("share")
    axes.set_title("Polarity")


def _draw_noise(axes: Any, statistics: Pair) -> None:
    for found, colour in zip(statistics, COLOURS, strict=True):
        classes = [n for n in found.noise[1:] if n.rate_hz]
        if not classes:
            continue
        x = [k for k, n in enumerate(found.noise[1:]) if n.rate_hz]
        rates = np.array([n.rate_hz for n in classes], np.float64)
        factor = np.exp([n.spread or 0.0 for n in classes])
        bars = (rates - rates / factor, rates * factor - rates)
        axes.errorbar(x, rates, bars, color=colour, marker="o", capsize=2)
        axes.set_yscale("log")
    labels = [brightness_label(edge).removesuffix(" of mean") for edge in BRIGHTNESS_EDGES]
    axes.set_xticks(range(len(labels)), labels)
    axes.set_xlabel("brightness / mean (bars: spread over pixels)")
    axes.set_ylabel("events per quiet pixel [Hz]")
    axes.set_title("Noise")


def _draw_readout(axes: Any, statistics: Pair) -> None:
    styles = (("one_row", "-", "o"), ("to_neighbour", "--", "s"), ("down", ":", "v"))
    labels = ("stamps of one row", "changes to neighbour", "changes downwards")
    for found, colour in zip(statistics, COLOURS, strict=True):
        for (key, line, marker), label in zip(styles, labels, strict=True):
            orders = [o for o in found.readout if o.steps]
            axes.plot(
                [o.from_mev_s for o in orders],
                [getattr(o, key) for o in orders],
                line,
                marker=marker,
                color=colour,
                label=label if found is statistics[0] else None,
            )
    axes.set_ylim(0, 1)
    axes.set_xlabel("event rate of the millisecond, from [Mev/s]")
    axes.set_ylabel("share")
    axes.set_title("Order of rows")
    axes.legend(fontsize=7)


def _draw_distances(axes: Any, rows: Sequence[Compared]) -> None:
    shown = [row for row in rows if row.distance is not None]
    axes.barh(range(len(shown)), [row.distance for row in shown], color="0.5")
    axes.set_yticks(range(len(shown)), [row.name for row in shown], fontsize=6)
    axes.invert_yaxis()
    axes.set_xlabel("distance")
    axes.set_title("Distances")
