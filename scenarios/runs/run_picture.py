"""The picture of a run in a notebook: the detector's response over time."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy.typing as npt

from scenarios.output.figures import figure_file
from scenarios.output.html import inline_svg
from scenarios.styles.method_style import method_style

SIZE_IN = (5.4, 3.0)
VERTICAL = "#80868e"
_THEME = (
    "--ink: currentColor; --paper: transparent; fill: currentColor; width: 34em; max-width: 100%"
)
"""The greys of the picture are those of the notebook's text, in a light and in a dark theme."""


def response_svg(
    name: str, method: str, summary: dict[str, Any], estimates: npt.NDArray[Any]
) -> str:
    """Return HS and VS over time as an `<svg>` element, with the time in view shaded.

    Args:
        name: name of the run; runs on one page have different ones.
        method: name of the detector.
        summary: contents of `summary.json`.
        estimates: (n,) structured array with `t_us`, `hs` and `vs`.
    """
    style, truth = method_style(method), summary["truth"]
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder) / "response"
        with figure_file(base, SIZE_IN) as figure:
            axes = figure.add_subplot()
            view_s = (truth["enters_view_us"] / 1e6, truth["leaves_view_us"] / 1e6)
            axes.axvspan(*view_s, color="#e3e6ea", linewidth=0, label="target in view")
            times_s = estimates["t_us"] / 1e6
            axes.plot(times_s, estimates["vs"], color=VERTICAL, label="VS, downward > 0")
            axes.plot(times_s, estimates["hs"], color=style.colour, label="HS, rightward > 0")
            axes.set(ylim=(-1.05, 1.05), xlabel="time [s]", ylabel="response [1]")
            axes.set_title(f"{style.label}; true direction {truth['direction']}", fontsize=9)
            figure.legend(loc="outside lower center", ncols=3, fontsize=8)
        svg = base.with_suffix(".svg").read_text(encoding="utf-8")
    label = f"response of the {style.label} over time"
    prefix = f"run-{crc32(name.encode()):08x}"
    text = str(inline_svg(svg, prefix=prefix, label=label))
    return text.replace("<svg ", f'<svg style="{_THEME}" ', 1)
