from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY
from scenarios.study.conditions import HIGH_THRESHOLDS
from scenarios.study.figures.all_figures import FIGURES, draw_figures
from scenarios.study.figures.comparison import draw_comparison
from scenarios.study.figures.condition import draw_condition
from scenarios.study.figures.truth import draw_truth
from scenarios.study.results import SequenceResult
from tests.scenarios.study.synthetic_results import make_run, make_sequence, make_snapshot

ALL = [
    make_sequence(lighting, omega)
    for lighting, omega in (("night", 1.42), ("day", 1.21), ("day", 1.61))
] + [make_sequence("day", 1.61, background=name) for name in ("wind", "shake")]
DRAW = (draw_condition, draw_comparison, draw_truth)


def text_of(path: Path) -> str:
    return " ".join(ElementTree.parse(path).getroot().itertext())


def text_of_figures(folder: Path, sequences: list[SequenceResult]) -> list[str]:
    """Draw the three kinds of figure and return the text in each."""
    for number, draw in enumerate(DRAW):
        draw(folder / str(number), sequences)
    return [text_of(folder / f"{number}.svg") for number in range(len(DRAW))]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("figures")
    files = draw_figures(folder, ALL)
    assert sorted(files) == sorted(folder.iterdir())
    return folder


def test_each_figure_is_written_as_svg_and_png(folder: Path) -> None:
    names = {figure.name for figure in FIGURES}
    assert {path.name for path in folder.iterdir()} == {
        name + ending for name in names for ending in (".svg", ".png")
    }


def test_the_day_figure_has_its_rows_and_its_velocities_in_order(folder: Path) -> None:
    day = text_of(folder / "day.svg")
    assert "1.42 rad/s" not in day
    assert day.index("1.21 rad/s") < day.index("1.61 rad/s")
    for text in ("APS frame", "saliency", "HS, VS [1]", "[px/s]", "true velocity", "time in view"):
        assert text in day


def test_images_are_embedded_in_the_file(folder: Path) -> None:
    images = [e for e in ElementTree.parse(folder / "day.svg").iter() if e.tag.endswith("image")]
    links = [value for e in images for name, value in e.attrib.items() if name.endswith("href")]
    assert len(links) == 4  # two velocities, with a frame and a map each
    assert all(link.startswith("data:image/png;base64,") for link in links)


def test_the_comparison_shows_seeds_and_times(folder: Path) -> None:
    text = text_of(folder / "comparison.svg")
    assert "3/3" in text
    assert "CPU time of an estimate [ms]" in text
    assert "contrast maximisation" in text


def test_a_method_that_did_not_run_has_no_row(tmp_path: Path) -> None:
    condition, comparison, truth = text_of_figures(
        tmp_path, [make_sequence(methods=(FLY,), seeds=(4,))]
    )
    assert "event-driven fly" in condition
    for text in (condition, comparison, truth):
        assert "contrast" not in text
        assert "frame-based" not in text
    assert "velocity error" not in truth
    assert "no value" not in truth


def test_a_method_without_decisions_or_with_wrong_ones_is_drawn(tmp_path: Path) -> None:
    silent = [make_run(method, 0, hs=0.0) for method in (FRAME_FLY, CONTRAST)]
    wrong = make_run(FLY, 0, hs=-0.5)
    assert wrong.scores["latency_ms"] is None
    half = make_sequence(omega_rad_s=2.01, runs=(make_run(FLY, 0), make_run(FLY, 1, hs=-0.5)))
    sequences = [make_sequence(runs=(wrong, *silent)), half]
    _, comparison, truth = text_of_figures(tmp_path, sequences)
    assert "0/1" in comparison
    assert "1/2" in comparison
    assert "1/2" in truth  # seeds with a latency
    assert "no value" in truth


def test_a_sequence_without_snapshots_or_estimates_is_drawn(tmp_path: Path) -> None:
    empty = make_sequence(
        snapshots=(replace(make_snapshot(box_px=None), roi_px=None),),
        runs=(replace(make_run(FLY, 0), estimates=()), make_run("my.own:Detector", 0)),
    )
    condition, comparison, _ = text_of_figures(
        tmp_path, [empty, make_sequence(snapshots=(), runs=())]
    )
    assert "APS frame" in condition
    assert "my.own:Detector" in comparison.replace("\n", "")


def test_moving_backgrounds_are_in_their_own_figure_only(folder: Path) -> None:
    text = text_of(folder / "background.svg")
    for words in ("wind, day", "shake, day", "event-driven fly", "right", "wrong", "none"):
        assert words in text
    assert "shake" not in text_of(folder / "truth.svg") + text_of(folder / "comparison.svg")


def test_runs_of_the_second_sensor_are_in_no_figure(folder: Path, tmp_path: Path) -> None:
    extra = [replace(make_run(FLY, 9, hs=-0.5), sensor=HIGH_THRESHOLDS)]
    sequences = [replace(one, runs=(*one.runs, *extra)) for one in ALL]
    draw_figures(tmp_path, sequences)
    assert (tmp_path / "truth.svg").read_bytes() == (folder / "truth.svg").read_bytes()
