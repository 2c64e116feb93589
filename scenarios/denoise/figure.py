"""Figures of the filters: ROC curves and areas by illuminance, and steps of the detectors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scenarios.denoise.measure import NO_FILTER, Row
from scenarios.denoise.roc import Roc
from scenarios.output.colours import SERIES
from scenarios.output.figures import figure_file
from scenarios.styles.method_style import method_style

COLOURS = {
    NO_FILTER: SERIES[4],
    "baf": SERIES[0],
    "stcf": SERIES[1],
    "time-surface": SERIES[2],
    "double-window": SERIES[3],
}
MARKERS = dict(zip(COLOURS, "osD^v", strict=True))
_PANEL_IN = 2.6


def draw_roc(path: Path, rows: Sequence[Row], curves: Mapping[float, Mapping[str, Roc]]) -> None:
    """Draw one panel of curves for each illuminance, and one of areas.

    Args:
        path: path of the figure, without a suffix.
        rows: rows of the filters.
        curves: curves by illuminance [lux] and filter.
    """
    with figure_file(path, (_PANEL_IN * (len(curves) + 1), _PANEL_IN + 0.4)) as figure:
        axes = figure.subplots(1, len(curves) + 1, squeeze=False)[0]
        for axis, (lux, of_filters) in zip(axes, curves.items(), strict=False):
            for name, roc in of_filters.items():
                axis.plot(roc.kept_noise, roc.kept_signal, color=COLOURS[name], label=name)
                signal, noise = roc.at_default
                axis.plot(noise, signal, MARKERS[name], color=COLOURS[name])
            axis.plot([0, 1], [0, 1], ":", color="#999999", linewidth=0.8)
            axis.set(title=f"{lux:g} lux", xlabel="noise kept", xlim=(0, 1), ylim=(0, 1))
        axes[0].set_ylabel("signal kept (dots: default threshold)")
        _draw_areas(axes[-1], rows)


def _draw_areas(axis: Any, rows: Sequence[Row]) -> None:
    for name in dict.fromkeys(row["filter"] for row in rows):
        own = sorted((r["illuminance_lux"], r["auc"]) for r in rows if r["filter"] == name)
        axis.plot(*zip(*own, strict=True), marker=MARKERS[name], color=COLOURS[name], label=name)
    axis.set(title="area", xlabel="illuminance [lux]", xscale="log", ylim=(0.4, 1.02))
    axis.legend(fontsize=7)


def draw_steps(path: Path, rows: Sequence[Row]) -> None:
    """Draw the share of right steps against illuminance: one panel for each detector.

    Args:
        path: path of the figure, without a suffix.
        rows: rows of the detectors.
    """
    methods = list(dict.fromkeys(row["method"] for row in rows))
    with figure_file(path, (_PANEL_IN * len(methods), _PANEL_IN + 0.4)) as figure:
        axes = figure.subplots(1, len(methods), squeeze=False, sharey=True)[0]
        for axis, method in zip(axes, methods, strict=True):
            for name in dict.fromkeys(row["filter"] for row in rows):
                own = sorted(
                    (row["illuminance_lux"], 100 * row["accuracy_after_100ms"])
                    for row in rows
                    if (row["method"], row["filter"]) == (method, name)
                    and row["accuracy_after_100ms"] is not None
                )
                if own:
                    axis.plot(
                        *zip(*own, strict=True),
                        marker=MARKERS[name],
                        color=COLOURS[name],
                        label=name,
                    )
            axis.set(
                title=method_style(method).label,
                xlabel="illuminance [lux]",
                xscale="log",
                ylim=(-3, 103),
            )
        axes[0].set_ylabel("right steps after 100 ms [%]")
        axes[-1].legend(fontsize=7)
