"""The command `characterise`: its output, the page, the JSON file, and refused arguments."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from emulator import SensorConfig
from emulator.characterisation import (
    EXPERIMENTS,
    Datasheet,
    Plot,
    Published,
    Quantity,
    Section,
    Style,
)
from emulator.characterisation.section import series
from scenarios.commands import characterise
from scenarios.commands.characterise import NUMBERS, PAGE, Characterise
from scenarios.datasheet import formatting
from scenarios.datasheet.digest import digest
from scenarios.datasheet.explanations import ANOTHER_SOURCE, note
from scenarios.datasheet.figures import draw, draw_svg
from scenarios.datasheet.json_export import datasheet_dict
from scenarios.datasheet.page import render_page
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_folder import SUMMARY
from scenarios.output.colours import OFF, ON, hex_of
from scenarios.output.terminal import execute

X = np.array([1.0, 10.0, 100.0])
PLOT = Plot(
    "A & B < C",
    "illuminance [lux]",
    "rate [Hz]",
    [
        series("measured", X, [1.0, np.nan, 3.0], Style.LINE, 0),
        series("published", [10.0], [2.0], Style.PUBLISHED),
        series("half", [1.0, 100.0], [1.5, 1.5], Style.GUIDE),
        series("steps", X, X, Style.STEPS),
        series("points", X, X),
    ],
    x_log=True,
)
SECTION = Section(
    "An experiment",
    "Light <on> a card.",
    [
        Quantity("rate", "Hz", 3.3, Published(3.0, "Somebody 1999"), "a note"),
        Quantity("not measured", "Hz", None),
    ],
    [PLOT],
)


class Tags(HTMLParser):
    """Collects ids and links of a page, and checks that each element is closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.ids: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in {"meta", "br"}:
            self.open.append(tag)
        for name, value in attrs:
            if name in {"src", "href"} and value is not None:
                self.links.append(value)
            if name == "id" and value is not None:
                self.ids.add(value)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run one experiment instead of all."""
    monkeypatch.setattr(
        characterise,
        "characterise",
        lambda config, *, seed, **_: Datasheet(
            config, seed, {"refractory": EXPERIMENTS["refractory"](config, seed=seed)}
        ),
    )


SHEET = Datasheet(SensorConfig(), 3, {"one": SECTION})


def page_with(**changes: object) -> str:
    return render_page(SHEET, changes={"preset": "davis346", **changes}, versions={"numpy": "2"})


@pytest.mark.usefixtures("quick")
def test_the_command_writes_a_folder_and_prints_the_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    folder = tmp_path / "sheet"
    assert execute(Characterise(out=folder, seed=4)) == 0
    assert {path.name for path in folder.iterdir()} == {PAGE, NUMBERS, SUMMARY}
    printed = capsys.readouterr().out
    assert "another sensor" not in printed
    for words in ("Refractory period", "DAVIS346", "270 µs", PAGE):
        assert words in printed
    first = (folder / NUMBERS).read_bytes()
    assert execute(Characterise(out=folder, seed=4)) == 0
    assert (folder / NUMBERS).read_bytes() == first
    assert json.loads(first)["sensor"]["refractory_us"] == 270


@pytest.mark.usefixtures("quick")
def test_a_modified_sensor_is_measured_and_marked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    options = SensorOptions("dvs128", set=("refractory_us=50", "aps.noise=false"))
    assert execute(Characterise(options, out=tmp_path / "sheet")) == 0
    json_export = json.loads((tmp_path / "sheet" / NUMBERS).read_text())
    assert json_export["asked_for"]["aps"] == {"noise": False}
    period = json_export["sections"]["refractory"]["figures"][0]["measured"]
    assert period == pytest.approx(50.0, rel=0.05)
    text = (tmp_path / "sheet" / PAGE).read_text()
    assert "emulated dvs128, modified" in text
    assert "refractory_us = 50, aps.noise = False" in text
    assert "The dvs128 has no APS frames" in text
    assert "270 µs *" in text
    assert "; published for another sensor" in text
    printed = capsys.readouterr().out
    assert "DAVIS346" not in printed
    assert "270 µs *" in printed
    assert "* published for another sensor" in printed
    assert json_export["sections"]["refractory"]["figures"][0]["published_for_another_sensor"]


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (
            Characterise(SensorOptions(set=("preset=kodak",)), out=Path("never")),
            ("'kodak'", "davis346"),
        ),
        (Characterise(SensorOptions(set=("theta_on=0",)), out=Path("never")), ("theta_on is 0",)),
        (
            Characterise(seed=-1, out=Path("never")),
            ("--seed is -1", "Allowed is a whole number from 0 to 4294967295"),
        ),
    ],
)
def test_bad_arguments_are_refused(
    command: Characterise, words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert execute(command) == 2
    printed = capsys.readouterr().err
    assert all(word in printed for word in words)
    assert "Traceback" not in printed
    assert not Path("never").exists()


@pytest.mark.usefixtures("quick")
def test_a_folder_not_written_by_flybench_is_left_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    assert execute(Characterise(out=tmp_path)) == 2
    assert "not written by flybench" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_an_interrupted_experiment_leaves_no_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(characterise, "characterise", fail)
    assert execute(Characterise(out=tmp_path / "sheet")) == 130
    assert list(tmp_path.iterdir()) == []


def test_the_page_is_well_formed_and_self_contained() -> None:
    text = page_with()
    tags = Tags()
    tags.feed(text)
    assert tags.open == []
    assert all(link.startswith("#") for link in tags.links)
    assert {link[1:] for link in tags.links} <= tags.ids
    assert "Light &lt;on&gt; a card." in text
    assert 'name="viewport"' in text
    assert "3.3 Hz" in text
    assert "+10.0 %" in text
    assert "Somebody 1999" in text


def quantities(*figures: tuple[str, float, float | None]) -> list[Quantity]:
    return [
        Quantity(name, "", value, None if known is None else Published(known, "Somebody 1999"))
        for name, value, known in figures
    ]


def test_the_summary_counts_what_agrees_and_names_what_does_not() -> None:
    figures = quantities(
        ("a", 1.05, 1.0), ("b", 1.9, 1.0), ("c", 9.0, 1.0), ("c", 9.0, 8.9), ("d", 0.1, 1.0)
    )
    elsewhere = Quantity("e", "", 9.0, Published(1.0, "Somebody 1999", another_sensor=True))
    other = replace(figures[0], name="of another sensor", counts=False)
    rest = [elsewhere, other, *quantities(("f", 1.0, None))]
    section = replace(SECTION, quantities=[*figures, *rest])
    found = digest(Datasheet(SensorConfig(), 3, {"one": section}))
    assert (found.compared, found.close, found.within_double) == (5, 2, 1)
    assert (found.far, found.elsewhere) == (["d"], 1)
    assert [key.quantity.name for key in found.key_figures] == ["a"]
    text = " ".join(page_with().split())
    assert "Of 1 comparisons with published figures" in text


def test_rows_whose_names_do_not_tell_their_meaning_are_explained() -> None:
    first, second = quantities(("variation of ON intervals", 1.0, 2.0)) * 2
    assert note(first, None).startswith("standard deviation of the intervals over their mean")
    assert note(second, first) == ANOTHER_SOURCE
    told = replace(first, note="1 for a Poisson process")
    assert note(told, None) == told.note


def test_curves_have_the_colours_of_their_polarity_and_different_markers() -> None:
    x = np.array([1.0, 2.0])
    named = [series(name, x, x, Style.LINE, k) for k, name in enumerate(("ON", "OFF", "jitter"))]
    lines = draw(replace(PLOT, series=named)).axes[0].get_lines()
    assert [line.get_color() for line in lines[:2]] == [hex_of(ON), hex_of(OFF)]
    assert len({line.get_marker() for line in lines}) == 3
    assert len({line.get_linestyle() for line in lines}) == 3


def test_a_legend_of_long_names_fits_into_the_figure() -> None:
    names = [f"DAVIS346 clip, {polarity}" for polarity in ("ON", "OFF") * 4]
    figure = draw(replace(PLOT, series=[series(name, X, X, Style.PUBLISHED) for name in names]))
    figure.canvas.draw()
    box = figure.legends[0].get_window_extent()
    assert box.x0 >= 0
    assert box.x1 <= figure.bbox.width


@pytest.mark.parametrize(("high", "labelled"), [(20.0, False), (8.0, True)])
def test_labels_between_decades_are_shown_only_within_a_decade(high: float, labelled: bool) -> None:
    plot = replace(PLOT, series=[series("a", [2.0, high], [1.0, 2.0], Style.LINE)])
    figure = draw(plot)
    figure.canvas.draw()
    labels = figure.axes[0].get_xticklabels(minor=True)
    assert any(label.get_text() for label in labels) == labelled


def test_a_section_without_published_figures_has_no_columns_for_them() -> None:
    heads = ["published", "difference", "source"]
    for known, expected in ((2.0, heads), (None, [])):
        section = replace(SECTION, quantities=quantities(("a", 1.0, known)))
        sheet = Datasheet(SensorConfig(), 3, {"one": section})
        page = render_page(sheet, changes={"preset": "davis346"}, versions={"numpy": "2"})
        text = page.split('<section id="one">')[1]
        assert [head for head in heads if f">{head}</th>" in text] == expected
        assert [head for head in heads if f'data-name="{head}"' in text] == expected


def test_figures_are_reproducible_svg() -> None:
    text = draw_svg(PLOT)
    root = ElementTree.fromstring(text)
    assert root.tag.endswith("svg")
    words = "".join(root.itertext())
    for label in ("A & B < C", "illuminance [lux]", "published"):
        assert label in words
    assert draw_svg(PLOT) == text
    assert not re.search(r"\d{4}-\d\d-\d\d", text)


def test_the_json_numbers_are_finite() -> None:
    exported = datasheet_dict(SHEET, changes={"preset": "davis346"}, versions={"numpy": "2"})
    text = json.dumps(exported, allow_nan=False)
    one = json.loads(text)["sections"]["one"]
    assert one["plots"][0]["series"][0]["y"] == [1.0, None, 3.0]
    assert one["figures"][0]["difference"] == pytest.approx(0.1)
    assert one["figures"][1]["measured"] is None


def test_numbers_as_text() -> None:
    assert formatting.with_unit(0.1794, "ln units") == "0.179 ln units"
    assert formatting.with_unit(2067.3, "Hz") == "2\u202f070 Hz"
    assert formatting.with_unit(5.013e-5, "Hz") == "5.01 × 10⁻⁵ Hz"
    assert formatting.with_unit(-0.0162, "µs") == "−0.0162 µs"
    assert formatting.with_unit(0.0, "") == "0"
    assert formatting.with_unit(None, "Hz") == formatting.NOT_MEASURED
    assert formatting.difference(Quantity("a", "", 28.0, Published(3.0, ""))) == "× 9.3"
    assert formatting.difference(Quantity("a", "", 478.0, Published(3.0, ""))) == "× 160"
    assert formatting.difference(Quantity("a", "", 2.0, Published(4.0, ""))) == "−50.0 %"
    assert formatting.difference(Quantity("a", "dB", 113.2, Published(120.0, ""))) == "−6.8 dB"
    assert formatting.difference(Quantity("a", "", 2.9999, Published(3.0, ""))) == "0.0 %"
    assert formatting.difference(Quantity("a", "", 2.0)) == ""
    assert (
        formatting.difference(Quantity("a", "Hz", 5.01e-5, Published(0.0, ""))) == "+5.01 × 10⁻⁵ Hz"
    )
    assert formatting.difference(Quantity("a", "Hz", 0.0, Published(0.0, ""))) == "0.0"
    assert formatting.short_source(Quantity("a", "", 2.0, Published(1.0, "Joubert 2021, X"))) == (
        "Joubert 2021"
    )


def test_every_experiment_is_in_the_data_sheet() -> None:
    assert len(EXPERIMENTS) >= 9
    assert len({measure.__module__ for measure in EXPERIMENTS.values()}) == len(EXPERIMENTS)
