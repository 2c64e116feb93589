"""GRMS against angular velocity: rank correlation and figure (paper, Fig. EX3 B)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from scenarios.output.figures import figure_file, literal
from scenarios.styles.lighting_style import lighting_style
from scenarios.styles.method_style import MethodStyle, method_style

Rows = Sequence[dict[str, Any]]
MIN_SPEEDS = 2


def spearman(omegas: Sequence[float], grms: Sequence[float | None]) -> float | None:
    """Return Spearman's rank correlation of GRMS with velocity; 1 if GRMS always rises.

    Returns:
        The correlation, in [−1, 1]. None with fewer than two velocities, if a GRMS is missing, or
        if all GRMS are equal.
    """
    values = [value for value in grms if value is not None]
    if len(values) < len(grms) or min(len(set(values)), len(set(omegas))) < MIN_SPEEDS:
        return None
    from scipy.stats import spearmanr  # half a second, which only this function should take

    return round(float(spearmanr(omegas, values).statistic), 9)


def spearman_by_seed(rows: Rows) -> dict[str, dict[str, float | None]]:
    """Return `spearman` by lighting and seed.

    Args:
        rows: rows with lighting, seed, omega_rad_s and grms.
    """
    found: dict[str, dict[str, float | None]] = {}
    for lighting, seed in dict.fromkeys((row["lighting"], row["seed"]) for row in rows):
        own = [row for row in rows if (row["lighting"], row["seed"]) == (lighting, seed)]
        value = spearman([r["omega_rad_s"] for r in own], [r["grms"] for r in own])
        found.setdefault(lighting, {})[str(seed)] = value
    return found


def draw_grms(path: Path, rows: Rows, *, method: str) -> None:
    """Draw GRMS against angular velocity: a faint line per seed, and a bold one for their mean.

    Args:
        path: path of the figure, without a suffix.
        rows: rows with lighting, seed, omega_rad_s and grms.
        method: name of the detector, for the title.
    """
    ranks, style = spearman_by_seed(rows), method_style(method)
    with figure_file(path, (5.2, 3.6)) as figure:
        axes = figure.add_subplot()
        for lighting in dict.fromkeys(row["lighting"] for row in rows):
            own = [row for row in rows if row["lighting"] == lighting and row["grms"] is not None]
            if own:
                _draw_lighting(axes, lighting, style, own, list(ranks[lighting].values()))
        axes.set_xlabel("angular velocity [rad/s]")
        axes.set_ylabel("GRMS of the response [1/s]")
        axes.set_ylim(bottom=0)
        axes.ticklabel_format(axis="y", scilimits=(-2, 3), useMathText=True)
        axes.set_title(f"GRMS against velocity: {literal(style.label)}")
        axes.legend(loc="upper left")


def _draw_lighting(
    axes: Axes, lighting: str, style: MethodStyle, rows: Rows, ranks: Sequence[float | None]
) -> None:
    omegas = sorted({row["omega_rad_s"] for row in rows})
    for seed in dict.fromkeys(row["seed"] for row in rows):
        own = sorted((r["omega_rad_s"], r["grms"]) for r in rows if r["seed"] == seed)
        axes.plot(*np.transpose(own), color=style.colour, alpha=0.25, linewidth=0.8)
    means = [np.mean([r["grms"] for r in rows if r["omega_rad_s"] == w]) for w in omegas]
    rising = sum(rank == 1.0 for rank in ranks)
    label = f"{lighting}: rises throughout in {rising} of {len(ranks)} seeds"
    line = lighting_style(lighting, style.colour)
    axes.plot(omegas, means, marker=style.marker, label=label, **line)
