"""The figure of `flybench detect`."""

from typing import Any

import pytest
from matplotlib.figure import Figure

from detector.estimate import MotionEstimate
from flybench.direction import Direction
from flybench.events import empty_events
from scenarios.detect import plot
from scenarios.detect.plot_data import PlotData
from scenarios.detect.run_detector import RecordingSlice


def drawn(responses: list[float]) -> Any:
    """Return the figure of a recording whose HS has these responses."""
    data = PlotData()
    for k, hs in enumerate(responses):
        estimate = MotionEstimate(
            k * 10_000, hs, 0.001, Direction.LEFT, abs(hs), (0.0, 0.0), (0.0, 0.0), None
        )
        data.add(RecordingSlice(empty_events(), (), (estimate,), None, 0))
    figure = Figure(layout="constrained")
    plot._draw(figure, data, (346, 260), "a.raw, fly: left\n2 of 58 steps name a direction")
    return figure


@pytest.mark.parametrize(
    ("responses", "limit"), [([0.0, -0.02], 0.022), ([0.5, 0.9], 0.99), ([], 1.1)]
)
def test_the_axis_of_the_responses_follows_the_data(responses: list[float], limit: float) -> None:
    axes = next(a for a in drawn(responses).axes if a.get_ylabel() == "response")
    assert axes.get_ylim() == pytest.approx((-limit, limit))


def test_the_title_says_how_many_steps_decided() -> None:
    assert "2 of 58 steps" in drawn([0.1]).get_suptitle()
