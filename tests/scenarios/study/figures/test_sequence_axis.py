from matplotlib.figure import Figure

from scenarios.pipeline.registry import FLY, FRAME_FLY
from scenarios.study.figures.sequence_axis import (
    add_legend,
    label_methods,
    label_sequences,
)
from tests.scenarios.study.synthetic_results import make_sequence

SEQUENCES = [make_sequence("day", 1.21), make_sequence("day", 1.61), make_sequence("night", 1.07)]


def test_positions_are_labelled_with_velocity_and_lighting() -> None:
    axes = Figure().add_subplot()
    label_sequences(axes, SEQUENCES)
    label_methods(axes, (FLY, FRAME_FLY))
    assert [text.get_text() for text in axes.get_xticklabels()] == ["1.21", "1.61", "1.07"]
    assert [text.get_text() for text in axes.get_xticklabels(minor=True)] == [
        "day [rad/s]",
        "night [rad/s]",
    ]
    assert list(axes.xaxis.get_minorticklocs()) == [0.5, 2.0]
    assert axes.get_yticklabels()[0].get_text().split() == ["event-driven", "fly"]


def test_the_legend_has_each_method_and_lighting_once() -> None:
    figure = Figure()
    add_legend(figure, SEQUENCES)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "event-driven fly",
        "frame-based fly",
        "contrast maximisation",
        "day",
        "night",
    ]
