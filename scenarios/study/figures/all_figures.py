"""The list of the study's figures: those of the paper, and the accuracy against ground truth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from scenarios.study.figures.background import draw_background
from scenarios.study.figures.comparison import draw_comparison
from scenarios.study.figures.condition import draw_condition
from scenarios.study.figures.overview import draw_overview
from scenarios.study.figures.truth import draw_truth
from scenarios.study.results import DEFAULT_SENSOR, STILL, SequenceResult, with_runs_of

Sequences = Sequence[SequenceResult]


@dataclass(frozen=True)
class Figure:
    """One figure.

    Attributes:
        name: name of its files, without a suffix.
        title: heading.
        counterpart: the figure of the paper to compare it with, in words.
        caption: what it shows, and what to look at.
        draw: draws sequences to a path without a suffix.
        lighting: lighting of the sequences that it shows; None: all.
        is_moving: True if it shows the sequences with a moving background; False: the paper's.
    """

    name: str
    title: str
    counterpart: str
    caption: str
    draw: Callable[[Path, Sequences], None]
    lighting: str | None = None
    is_moving: bool = False

    def select(self, sequences: Sequences) -> list[SequenceResult]:
        """Return the sequences that it shows, sorted by lighting and then by velocity."""
        own = [
            one
            for one in sequences
            if self.lighting in (None, one.lighting) and self.is_moving == (one.background != STILL)
        ]
        return sorted(own, key=lambda one: (one.lighting, one.omega_rad_s))


_CONDITION = (
    "One column for each velocity. A: the last APS frame before the middle of the crossing, with "
    "the true box of the vehicle at that moment (the frame is older by up to one frame interval); "
    "the saliency of the event-driven fly with its region of interest; and its responses HS and "
    "VS. Positive HS is rightward. B: the responses of the frame-based fly. C: the image velocity "
    "estimated by contrast maximisation (solid) and the true one (dashed). Grey background: the "
    "vehicle is in view. Faint lines are single seeds, bold lines their mean. The strip shows "
    "whether each decision of the first seed was correct. Steps without a decision have no "
    "velocity. Small arrows mark values outside the panel. "
)
OVERVIEW = Figure(
    "overview",
    "Correct steps of every method",
    "Not in the paper, which had no exact ground truth",
    "Share of the steps that name the true direction, over all velocities: mean over the seeds and "
    "its 95 % interval (Student's t). Day is filled, night is hollow. A method without a point had "
    "no step.",
    draw_overview,
)
"""The picture at the top of the report."""
FIGURES = (
    OVERVIEW,
    Figure(
        "day",
        "By day",
        "In the paper: Fig. EX1, panels A to C",
        _CONDITION
        + "Compare the strength and the steadiness of HS between velocities, and with B.",
        draw_condition,
        "day",
    ),
    Figure(
        "night",
        "At night",
        "In the paper: Fig. EX2, panels A to C",
        _CONDITION + "Note how blurred and how few the frames are, and how little remains of B.",
        draw_condition,
        "night",
    ),
    Figure(
        "comparison",
        "Comparison of the methods",
        "In the paper: Fig. EX3, panels A to D",
        "A: mean image speed over the settled steps that name a direction, and the true one. B: "
        "gradient root mean square of the response before normalisation; the paper claims that it "
        "rises with velocity. C: number of seeds in which the direction of the whole crossing is "
        "correct. D: CPU time of one estimate on one core, from the same events for all methods, "
        "with one tick for each sequence and seed; methods differ in how often they make an "
        "estimate. Day is filled and solid, night is hollow and dashed. Faint lines are single "
        "seeds.",
        draw_comparison,
    ),
    Figure(
        "truth",
        "Accuracy against ground truth",
        "Not in the paper, which had no exact ground truth",
        "Mean over the seeds and its 95 % interval (Student's t), by sequence and method. Day is "
        "filled, night is hollow. If only some seeds have a value, their number is given at the "
        "point. A cross marks a method and sequence without a value, such as the latency where no "
        "step was correct. Latency and CPU time have logarithmic scales. Below the dotted line one "
        "core keeps up with the sensor.",
        draw_truth,
    ),
    Figure(
        "background",
        "Moving background",
        "Not in the paper, whose sequences have a still background",
        "One column for each background: trees in the wind, a vehicle that drives the other way "
        "behind the target, a shaking camera, and all three. Only the middle 0.3 s of the crossing "
        "are drawn, at one velocity. Above: the last APS frame before the middle, and the saliency "
        "of the event-driven fly with its region of interest. Below: the shares of the settled "
        "steps, over all seeds. “No attention” is the same fly with the whole field as its region.",
        draw_background,
        is_moving=True,
    ),
)


def draw_figures(folder: Path, sequences: Sequences) -> list[Path]:
    """Draw every figure that shows at least one of the sequences.

    Args:
        folder: existing output folder.
        sequences: one result or more, in any order.

    Returns:
        The files, one SVG and one PNG for each figure.
    """
    files = []
    sequences = with_runs_of(sequences, DEFAULT_SENSOR)
    for figure in FIGURES:
        if shown := figure.select(sequences):
            figure.draw(folder / figure.name, shown)
            files += [folder / f"{figure.name}.svg", folder / f"{figure.name}.png"]
    return files
