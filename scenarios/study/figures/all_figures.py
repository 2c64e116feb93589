"""The study's figures: each of the paper's anew, and what truth can tell beside them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from scenarios.study import results
from scenarios.study.figures.comparison import draw_comparison
from scenarios.study.figures.condition import draw_condition
from scenarios.study.figures.truth import draw_truth

Sequences = Sequence[results.Sequence]


@dataclass(frozen=True)
class Figure:
    """One figure.

    Attributes:
        name: of its files, without a suffix.
        title: above it.
        counterpart: beside which figure of the paper it can be laid, in words.
        caption: what it shows and what to look at.
        draw: draws it to a path without a suffix.
        lighting: of the sequences that it shows; None: of all.
    """

    name: str
    title: str
    counterpart: str
    caption: str
    draw: Callable[[Path, Sequences], None]
    lighting: str | None = None

    def of(self, sequences: Sequences) -> list[results.Sequence]:
        """Those of the sequences that it shows, by light and then by velocity."""
        own = [one for one in sequences if self.lighting in (None, one.lighting)]
        return sorted(own, key=lambda one: (one.lighting, one.omega_rad_s))


_CONDITION = (
    "A column a velocity. A: the last APS frame before a moment halfway through the crossing, "
    "with the vehicle's true box at that moment (the frame is older by up to a frame interval), "
    "the event-driven fly's saliency with its region of interest, and its responses HS and VS; "
    "positive HS is rightward. B: the frame-based fly's. C: the image velocity by contrast "
    "maximisation, dashed the true one. Grey: the vehicle is in view. Faint lines are single "
    "seeds, bold ones their mean; the strip tells whether each decision of the first seed was "
    "right. Steps without a decision have no velocity; small arrows lie beyond the panel. "
)
FIGURES = (
    Figure(
        "day",
        "By day",
        "In the paper: Fig. EX1, panels A to C",
        _CONDITION + "Look at how high and how steady HS stands over the velocities, and at B.",
        draw_condition,
        "day",
    ),
    Figure(
        "night",
        "By night",
        "In the paper: Fig. EX2, panels A to C",
        _CONDITION
        + "Look at how blurred the frames are, how few there are, and what is left of B.",
        draw_condition,
        "night",
    ),
    Figure(
        "comparison",
        "The methods side by side",
        "In the paper: Fig. EX3, panels A to D",
        "A: mean image speed of the settled steps that name a motion, and the true one. B: "
        "gradient root mean square of the response before normalisation; does it rise with "
        "velocity? C: in how many seeds the whole crossing's direction is right. D: CPU time of an "
        "estimate, a tick a sequence and seed, on one core and from the same events; methods "
        "differ in how often they make one. Filled and solid by day, hollow and dashed by night; "
        "faint lines are single seeds.",
        draw_comparison,
    ),
    Figure(
        "truth",
        "What truth tells",
        "Beyond the paper, since here truth is known",
        "Mean over the seeds and its 95 % interval (Student's t), by sequence and method; filled "
        "by day, hollow by night. Where only some seeds have a figure, the point tells how many; a "
        "cross is a method and sequence without any, such as a latency where no step was right. "
        "The scales of latency and CPU time are logarithmic; below the dotted line one core keeps "
        "up with the sensor.",
        draw_truth,
    ),
)


def draw_figures(folder: Path, sequences: Sequences) -> list[Path]:
    """Draw every figure of which there is a sequence.

    Args:
        folder: where to, which is there.
        sequences: what the study found, one at least, in any order.

    Returns:
        The files, an SVG and a PNG a figure.
    """
    files = []
    for figure in FIGURES:
        if own := figure.of(sequences):
            figure.draw(folder / figure.name, own)
            files += [folder / f"{figure.name}.svg", folder / f"{figure.name}.png"]
    return files
