"""How figures look, and how they are written: as PNG for slides and as SVG for papers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

DPI = 150
_STYLE: Any = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.titlesize": 13,
    "figure.titleweight": "bold",
    "legend.frameon": False,
    "svg.hashsalt": "flybench",
    "svg.fonttype": "none",
}


@contextmanager
def figure_file(path: Path, size_in: tuple[float, float]) -> Iterator[Figure]:
    """Give a figure to draw on; at the end it is written as `path`.png and `path`.svg.

    The same drawing gives the same bytes: neither file holds the time.

    Args:
        path: without a suffix.
        size_in: width and height [inch].
    """
    with mpl.rc_context(rc=_STYLE):
        figure = Figure(figsize=size_in, layout="constrained")
        FigureCanvasAgg(figure)
        yield figure
        for suffix, metadata in ((".png", {"Software": None}), (".svg", {"Date": None})):
            figure.savefig(path.with_name(path.name + suffix), dpi=DPI, metadata=metadata)
