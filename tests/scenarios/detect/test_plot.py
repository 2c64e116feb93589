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


def drawn(responses: list[float]) -> Any:
    """Return the figure of a recording whose HS has these responses."""
    data, verdict = PlotData(), RecordingVerdict()
    for k, hs in enumerate(responses, start=1):
        estimate = MotionEstimate(
            k * 10_000, hs, 0.001, Direction.LEFT, abs(hs), (0.0, 0.0), (0.0, 0.0), None
        )
        part = RecordingSlice(empty_events(), (), (estimate,), None, 0)
        data.add(part)
        verdict.add(part)
    figure = Figure(layout="constrained")
    plot._draw(figure, data, (346, 260), "a.raw, fly", verdict)
    return figure


def response_axes(figure: Any) -> Any:
    return next(axes for axes in figure.axes if axes.get_ylabel() == "response")


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


def test_a_figure_beyond_the_memory_budget_is_refused(tmp_path: Path) -> None:
    size = (30_000, 30_000)
    with pytest.raises(MemoryBudgetError, match="A figure of 30000×30000 px needs"):
        plot.write_plot(tmp_path / "a.png", PlotData(), size, "a", RecordingVerdict())
