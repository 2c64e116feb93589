import math
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from flybench.direction import Direction
from scenarios.pipeline.registry import CONTRAST, FLY
from scenarios.study.figures.response_panels import (
    NO_DECISION,
    WRONG,
    draw_response,
    draw_velocity,
    runs_of,
)
from scenarios.styles.method_style import method_style
from tests.scenarios.study.synthetic_results import IN_VIEW_US, make_run, make_sequence


@pytest.fixture
def axes() -> Axes:
    return Figure().add_subplot()


def bold_lines(axes: Axes, colour: str) -> list[list[float]]:
    return [
        list(np.asarray(line.get_ydata(), float))
        for line in axes.get_lines()
        if line.get_color() == colour and line.get_linewidth() > 1
    ]


def test_the_bold_line_is_the_mean_of_the_seeds(axes: Axes) -> None:
    sequence = make_sequence()
    draw_response(axes, sequence, FLY)
    runs = runs_of(sequence, FLY)
    assert [run.seed for run in runs] == [0, 1, 2]
    (mean,) = bold_lines(axes, method_style(FLY).colour)
    assert mean == pytest.approx(np.mean([[e.hs for e in run.estimates] for run in runs], axis=0))
    times_s = [e.t_us / 1e6 - 0.2 for e in runs[0].estimates]
    assert np.asarray(axes.get_lines()[-1].get_xdata(), float) == pytest.approx(times_s)
    peak = max(mean)
    assert [text.get_text() for text in axes.texts] == [f"peak HS {peak:.2g}"]


def test_the_strip_shows_correct_wrong_and_no_decisions(axes: Axes) -> None:
    run = make_run(FLY, 0)
    turned = [
        replace(e, direction=Direction.UP) if e.t_us > 600_000 and e.hs > 0 else e
        for e in run.estimates
    ]
    draw_response(axes, make_sequence(runs=(replace(run, estimates=tuple(turned)),)), FLY)
    bars = [
        (to_hex(tuple(np.asarray(c.get_facecolor())[0])), c.get_paths()[0].get_extents())
        for c in axes.collections
    ]
    assert [colour for colour, _ in bars] == [
        NO_DECISION,
        method_style(FLY).colour.lower(),
        WRONG,
        NO_DECISION,
    ]
    assert (bars[1][1].x0, bars[1][1].x1) == pytest.approx((0.05, 0.45))


def test_a_velocity_has_gaps_where_no_direction_is_named(axes: Axes) -> None:
    sequence = make_sequence(seeds=(0,))
    draw_velocity(axes, sequence, CONTRAST, top_px_s=400.0)
    (estimated,) = bold_lines(axes, method_style(CONTRAST).colour)
    times = [e.t_us for e in runs_of(sequence, CONTRAST)[0].estimates]
    for t_us, value in zip(times, estimated, strict=True):
        in_view = IN_VIEW_US[0] < t_us <= IN_VIEW_US[1]
        assert value == pytest.approx(324 * 1.21) if in_view else math.isnan(value)
    (truth,) = bold_lines(axes, "black")
    assert set(truth) == {324 * 1.21}


def test_a_velocity_outside_the_panel_is_an_arrow_at_its_edge(axes: Axes) -> None:
    draw_velocity(
        axes, make_sequence(runs=(make_run(CONTRAST, 0, speed_px_s=-900),)), CONTRAST, top_px_s=400
    )
    arrows = [line for line in axes.get_lines() if line.get_marker() == "v"]
    assert {float(y) for line in arrows for y in np.asarray(line.get_ydata())} == {
        axes.get_ylim()[0]
    }
