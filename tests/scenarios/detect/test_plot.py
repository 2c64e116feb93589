"""The figure of `flybench detect`."""

from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from detector.estimate import MotionEstimate
from flybench.direction import Direction
from flybench.events import empty_events
from flybench.memory import MemoryBudgetError
from scenarios.detect import plot
from scenarios.detect.plot_data import PlotData
from scenarios.detect.run_detector import RecordingSlice
from scenarios.detect.verdict import RecordingVerdict
from scenarios.styles.method_style import method_style


def drawn(responses: list[float]) -> Any:
    """Return the figure of a recording whose HS has these responses."""
    data, verdict = PlotData(), RecordingVerdict()
    for k, hs in enumerate(responses, start=1):
        estimate = MotionEstimate(
            k * 10_000,
            hs,
            0.001,
            Direction.LEFT,
            abs(hs),
            (0.0, 0.0),
            (0.0, 0.0),
            (90, 60, 200, 140),
        )
        part = RecordingSlice(empty_events(), (), (estimate,), None, 0)
        data.add(part)
        verdict.add(part)
    figure = Figure(layout="constrained")
    plot._draw(figure, data, (346, 260), "a.raw, fly", verdict, method_style("fly"))
    return figure


def response_axes(figure: Any) -> Any:
    return next(axes for axes in figure.axes if axes.get_ylabel() == "response [1]")


@pytest.mark.parametrize(
    ("responses", "limit"), [([0.0, -0.02], 0.022), ([0.5, 0.9], 0.99), ([], 1.1)]
)
def test_the_axis_of_the_responses_follows_the_data(responses: list[float], limit: float) -> None:
    assert response_axes(drawn(responses)).get_ylim() == pytest.approx((-limit, limit))


def test_the_title_says_how_many_steps_decided() -> None:
    assert drawn([-0.1] * 6).get_suptitle() == (
        "a.raw, fly: left\n6 of 6 steps name a direction, 6 of these left"
    )


def test_the_figure_shows_shares_and_spans() -> None:
    axes = response_axes(drawn([-0.1] * 6))
    assert axes.get_title() == ("6 steps: 0 % right, 100 % left, 0 % up, 0 % down, 0 % none")
    spans = [p for p in axes.patches if p.get_label() == "spans of one direction"]
    assert [(p.get_x(), p.get_width()) for p in spans] == [(0.0, pytest.approx(0.06))]


def test_the_box_is_explained_and_the_axes_have_units() -> None:
    (axes,) = (axes for axes in drawn([-0.1] * 6).axes if axes.images)
    (box,) = axes.patches
    assert (box.get_x(), box.get_y(), box.get_width(), box.get_height()) == (90, 60, 110, 80)
    shown = {
        text.get_text(): handle
        for text, handle in zip(
            axes.get_legend().get_texts(), axes.get_legend().legend_handles, strict=True
        )
    }
    assert list(shown) == ["ON", "OFF", "region of interest\nof the method"]
    assert shown["region of interest\nof the method"].get_color() == method_style("fly").colour
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [px]", "y [px]")


def test_a_figure_beyond_the_memory_budget_is_refused(tmp_path: Path) -> None:
    size = (30_000, 30_000)
    with pytest.raises(MemoryBudgetError, match="A figure of 30000×30000 px needs"):
        plot.write_plot(tmp_path / "a.png", PlotData(), size, "a", RecordingVerdict(), method="fly")
