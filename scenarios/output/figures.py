"""Style of the figures, and writing them as PNG (for slides) and SVG (for papers)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from flybench.printable import printable

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


def literal(text: str) -> str:
    """Return a text that Matplotlib draws as it is: between two `$`, it would draw a formula."""
    return printable(text).replace("$", r"\$")


@contextmanager
def figure_file(path: Path, size_in: tuple[float, float]) -> Iterator[Figure]:
    """Yield an empty figure; at the end of the block, write it as `path`.png and `path`.svg.

    Equal drawings give files with equal bytes, because neither file contains a date.

    Args:
        path: path of the files, without a suffix.
        size_in: width and height of the figure [inch].
    """
    with mpl.rc_context(rc=_STYLE):
        figure = Figure(figsize=size_in, layout="constrained")
        FigureCanvasAgg(figure)
        yield figure
        for suffix, metadata in ((".png", {"Software": None}), (".svg", {"Date": None})):
            figure.savefig(path.with_name(path.name + suffix), dpi=DPI, metadata=metadata)
            figure.set_layout_engine("none")  # a layout takes as long as a drawing; keep the first
