from matplotlib.figure import Figure

from scenarios.pipeline.registry import FLY, FRAME_FLY
from scenarios.study.figures.sequence_axis import (
    add_legend,
    light_line,
    name_methods,
    name_sequences,
)
from tests.scenarios.study.hand_made import a_sequence

SEQUENCES = [a_sequence("day", 1.21), a_sequence("day", 1.61), a_sequence("night", 1.07)]


def test_places_are_named_by_velocity_and_light() -> None:
    axes = Figure().add_subplot()
    name_sequences(axes, SEQUENCES)
    name_methods(axes, (FLY, FRAME_FLY))
    assert [text.get_text() for text in axes.get_xticklabels()] == ["1.21", "1.61", "1.07"]
    assert [text.get_text() for text in axes.get_xticklabels(minor=True)] == [
        "day [rad/s]",
        "night [rad/s]",
    ]
    assert list(axes.xaxis.get_minorticklocs()) == [0.5, 2.0]
    assert axes.get_yticklabels()[0].get_text().split() == ["event-driven", "fly"]


def test_the_legend_names_methods_and_lights_once() -> None:
    figure = Figure()
    add_legend(figure, SEQUENCES)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "event-driven fly",
        "frame-based fly",
        "contrast maximisation",
        "day",
        "night",
    ]


def test_night_is_hollow_and_day_is_not() -> None:
    assert light_line("day", "#123456")["markerfacecolor"] == "#123456"
    assert light_line("night", "#123456")["markerfacecolor"] == "white"
