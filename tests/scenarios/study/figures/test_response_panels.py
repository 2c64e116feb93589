import math
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from flybench.direction import Direction
from scenarios.pipeline.registry import CONTRAST, FLY
from scenarios.study.figures.method_style import method_style
from scenarios.study.figures.response_panels import (
    SILENT,
    WRONG,
    draw_response,
    draw_velocity,
    runs_of,
)
from tests.scenarios.study.hand_made import IN_VIEW_US, a_run, a_sequence


@pytest.fixture
def axes() -> Axes:
    return Figure().add_subplot()


def bold(axes: Axes, colour: str) -> list[list[float]]:
    return [
        list(np.asarray(line.get_ydata(), float))
        for line in axes.get_lines()
        if line.get_color() == colour and line.get_linewidth() > 1
    ]


def test_the_bold_line_is_the_mean_of_the_seeds_over_the_time_in_view(axes: Axes) -> None:
    sequence = a_sequence()
    draw_response(axes, sequence, FLY)
    runs = runs_of(sequence, FLY)
    assert [run.seed for run in runs] == [0, 1, 2]
    (mean,) = bold(axes, method_style(FLY).colour)
    assert mean == pytest.approx(np.mean([[e.hs for e in run.estimates] for run in runs], axis=0))
    times_s = [e.t_us / 1e6 - 0.2 for e in runs[0].estimates]
    assert np.asarray(axes.get_lines()[-1].get_xdata(), float) == pytest.approx(times_s)
    peak = max(mean)
    assert [text.get_text() for text in axes.texts] == [f"peak HS {peak:.2g}"]


def test_the_strip_tells_right_from_wrong_and_from_none(axes: Axes) -> None:
    run = a_run(FLY, 0)
    turned = [
        replace(e, direction=Direction.UP) if e.t_us > 600_000 and e.hs > 0 else e
        for e in run.estimates
    ]
    draw_response(axes, a_sequence(runs=(replace(run, estimates=tuple(turned)),)), FLY)
    bars = [
        (to_hex(tuple(np.asarray(c.get_facecolor())[0])), c.get_paths()[0].get_extents())
        for c in axes.collections
    ]
    assert [colour for colour, _ in bars] == [
        SILENT,
        method_style(FLY).colour.lower(),
        WRONG,
        SILENT,
    ]
    assert (bars[1][1].x0, bars[1][1].x1) == pytest.approx((0.05, 0.45))


def test_a_velocity_stands_beside_the_true_one_and_has_gaps_where_none_is_named(
    axes: Axes,
) -> None:
    sequence = a_sequence(seeds=(0,))
    draw_velocity(axes, sequence, CONTRAST, top_px_s=400.0)
    (told,) = bold(axes, method_style(CONTRAST).colour)
    times = [e.t_us for e in runs_of(sequence, CONTRAST)[0].estimates]
    for t_us, value in zip(times, told, strict=True):
        seen = IN_VIEW_US[0] < t_us <= IN_VIEW_US[1]
        assert value == pytest.approx(324 * 1.21) if seen else math.isnan(value)
    (truth,) = bold(axes, "black")
    assert set(truth) == {324 * 1.21}


def test_a_velocity_beyond_the_panel_is_an_arrow_at_its_edge(axes: Axes) -> None:
    draw_velocity(
        axes, a_sequence(runs=(a_run(CONTRAST, 0, speed_px_s=-900),)), CONTRAST, top_px_s=400
    )
    arrows = [line for line in axes.get_lines() if line.get_marker() == "v"]
    assert {float(y) for line in arrows for y in np.asarray(line.get_ydata())} == {
        axes.get_ylim()[0]
    }
