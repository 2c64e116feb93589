from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY
from scenarios.study.figures.all_figures import FIGURES, draw_figures
from scenarios.study.figures.comparison import draw_comparison
from scenarios.study.figures.condition import draw_condition
from scenarios.study.figures.truth import draw_truth
from scenarios.study.results import Sequence
from tests.scenarios.study.hand_made import a_run, a_sequence, a_snapshot

ALL = [a_sequence(light, omega) for light, omega in (("night", 1.42), ("day", 1.21), ("day", 1.61))]
DRAW = (draw_condition, draw_comparison, draw_truth)


def words_of(path: Path) -> str:
    return " ".join(ElementTree.parse(path).getroot().itertext())


def drawn_words(folder: Path, sequences: list[Sequence]) -> list[str]:
    """What stands in each of the three kinds of figure."""
    for number, draw in enumerate(DRAW):
        draw(folder / str(number), sequences)
    return [words_of(folder / f"{number}.svg") for number in range(len(DRAW))]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("figures")
    files = draw_figures(folder, ALL)
    assert sorted(files) == sorted(folder.iterdir())
    return folder


def test_each_figure_comes_as_svg_and_png(folder: Path) -> None:
    names = {figure.name for figure in FIGURES}
    assert {path.name for path in folder.iterdir()} == {
        name + ending for name in names for ending in (".svg", ".png")
    }


def test_a_light_has_its_velocities_in_order_and_its_rows(folder: Path) -> None:
    day = words_of(folder / "day.svg")
    assert "1.42 rad/s" not in day
    assert day.index("1.21 rad/s") < day.index("1.61 rad/s")
    for words in ("APS frame", "saliency", "HS, VS [1]", "[px/s]", "true velocity", "time in view"):
        assert words in day


def test_pictures_are_inside_the_file(folder: Path) -> None:
    images = [e for e in ElementTree.parse(folder / "day.svg").iter() if e.tag.endswith("image")]
    links = [value for e in images for name, value in e.attrib.items() if name.endswith("href")]
    assert len(links) == 4  # two velocities, a frame and a map each
    assert all(link.startswith("data:image/png;base64,") for link in links)


def test_comparison_counts_seeds_and_tells_times(folder: Path) -> None:
    words = words_of(folder / "comparison.svg")
    assert "3/3" in words
    assert "CPU time of an estimate [ms]" in words
    assert "contrast maximisation" in words


def test_a_method_that_did_not_run_has_no_row(tmp_path: Path) -> None:
    condition, comparison, truth = drawn_words(tmp_path, [a_sequence(methods=(FLY,), seeds=(4,))])
    assert "event-driven fly" in condition
    for words in (condition, comparison, truth):
        assert "contrast" not in words
        assert "frame-based" not in words
    assert "velocity error" not in truth
    assert "never" not in truth


def test_a_method_that_is_silent_or_wrong_is_drawn_too(tmp_path: Path) -> None:
    silent = [a_run(method, 0, hs=0.0) for method in (FRAME_FLY, CONTRAST)]
    wrong = a_run(FLY, 0, hs=-0.5)
    assert wrong.judgement["latency_ms"] is None
    half = a_sequence(omega_rad_s=2.01, runs=(a_run(FLY, 0), a_run(FLY, 1, hs=-0.5)))
    sequences = [a_sequence(runs=(wrong, *silent)), half]
    _, comparison, truth = drawn_words(tmp_path, sequences)
    assert "0/1" in comparison
    assert "1/2" in comparison
    assert "1/2" in truth  # seeds with a latency
    assert "never" in truth


def test_nothing_seen_and_nothing_said_still_draws(tmp_path: Path) -> None:
    blind = a_sequence(
        snapshots=(replace(a_snapshot(box_px=None), roi_px=None),),
        runs=(replace(a_run(FLY, 0), estimates=()), a_run("my.own:Detector", 0)),
    )
    condition, comparison, _ = drawn_words(tmp_path, [blind, a_sequence(snapshots=(), runs=())])
    assert "APS frame" in condition
    assert "my.own:Detector" in comparison.replace("\n", "")
