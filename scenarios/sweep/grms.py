"""GRMS against angular velocity: does the response tell slow from fast (paper, figure 5 B)?"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from scipy.stats import spearmanr

from scenarios.output.figures import figure_file

Rows = Sequence[dict[str, Any]]
COLOURS = {"day": "#d1742a", "night": "#31508f"}
LEAST_SPEEDS = 2


def spearman(omegas: Sequence[float], grms: Sequence[float | None]) -> float | None:
    """Rank correlation of GRMS with velocity, 1 where it always rises.

    Returns:
        In [−1, 1]; None with fewer than two velocities, or where a GRMS is missing or all are one.
    """
    values = [value for value in grms if value is not None]
    if len(values) < len(grms) or min(len(set(values)), len(set(omegas))) < LEAST_SPEEDS:
        return None
    return round(float(spearmanr(omegas, values).statistic), 9)


def spearman_by_seed(rows: Rows) -> dict[str, dict[str, float | None]]:
    """`spearman` by light and seed, of rows with lighting, seed, omega_rad_s and grms."""
    found: dict[str, dict[str, float | None]] = {}
    for light, seed in dict.fromkeys((row["lighting"], row["seed"]) for row in rows):
        own = [row for row in rows if (row["lighting"], row["seed"]) == (light, seed)]
        value = spearman([r["omega_rad_s"] for r in own], [r["grms"] for r in own])
        found.setdefault(light, {})[str(seed)] = value
    return found


def draw_grms(path: Path, rows: Rows, *, method: str) -> None:
    """Draw GRMS against angular velocity, a faint line a seed and a bold one for their mean.

    Args:
        path: of the figure, without a suffix.
        rows: with lighting, seed, omega_rad_s and grms.
        method: the detector's name.
    """
    ranks = spearman_by_seed(rows)
    with figure_file(path, (5.2, 3.6)) as figure:
        axes = figure.add_subplot()
        for light in dict.fromkeys(row["lighting"] for row in rows):
            own = [row for row in rows if row["lighting"] == light and row["grms"] is not None]
            if own:
                _draw_light(axes, light, own, list(ranks[light].values()))
        axes.set_xlabel("angular velocity [rad/s]")
        axes.set_ylabel("GRMS of the response [1/s]")
        axes.set_ylim(bottom=0)
        axes.ticklabel_format(axis="y", scilimits=(-2, 3), useMathText=True)
        axes.set_title(f"GRMS against velocity: {method}")
        axes.legend(loc="upper left")


def _draw_light(axes: Axes, light: str, rows: Rows, ranks: Sequence[float | None]) -> None:
    colour = COLOURS[light]
    omegas = sorted({row["omega_rad_s"] for row in rows})
    for seed in dict.fromkeys(row["seed"] for row in rows):
        own = sorted((r["omega_rad_s"], r["grms"]) for r in rows if r["seed"] == seed)
        axes.plot(*np.transpose(own), color=colour, alpha=0.25, linewidth=0.8)
    means = [np.mean([r["grms"] for r in rows if r["omega_rad_s"] == w]) for w in omegas]
    rising = sum(rank == 1.0 for rank in ranks)
    label = f"{light}: rises throughout in {rising} of {len(ranks)} seeds"
    axes.plot(omegas, means, color=colour, marker="o", linewidth=2, label=label)
