"""The data sheet: a command, a page, numbers, and what is refused."""

import json
import re
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
from scenarios.datasheet import rows
from scenarios.datasheet.figures import draw_svg
from scenarios.datasheet.numbers import as_dict
from scenarios.datasheet.page import page
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_folder import SUMMARY
from scenarios.output.terminal import execute

X = np.array([1.0, 10.0, 100.0])
PLOT = Plot(
    "A & B < C",
    "light [lux]",
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
        Quantity("not seen", "Hz", None),
    ],
    [PLOT],
)


class Tags(HTMLParser):
    """Collects what a page refers to, and whether its elements close."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.names: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in {"meta", "br"}:
            self.open.append(tag)
        for name, value in attrs:
            if name in {"src", "href"} and value is not None:
                self.links.append(value)
            if name == "id" and value is not None:
                self.names.add(value)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """One experiment instead of all."""
    monkeypatch.setattr(
        characterise,
        "characterise",
        lambda config, *, seed, **_: Datasheet(
            config, seed, {"refractory": EXPERIMENTS["refractory"](config, seed=seed)}
        ),
    )


SHEET = Datasheet(SensorConfig(), 3, {"one": SECTION})


def whole_page(**changes: object) -> str:
    return page(SHEET, changes={"preset": "davis346", **changes}, versions={"numpy": "2"})


@pytest.mark.usefixtures("quick")
def test_command_writes_a_folder_and_prints_the_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    folder = tmp_path / "sheet"
    assert execute(Characterise(out=folder, seed=4)) == 0
    assert {path.name for path in folder.iterdir()} == {PAGE, NUMBERS, SUMMARY}
    said = capsys.readouterr().out
    assert "another sensor" not in said
    for words in ("Refractory period", "DAVIS346", "3 µs", PAGE):
        assert words in said
    first = (folder / NUMBERS).read_bytes()
    assert execute(Characterise(out=folder, seed=4)) == 0
    assert (folder / NUMBERS).read_bytes() == first
    assert json.loads(first)["sensor"]["refractory_us"] == 3


@pytest.mark.usefixtures("quick")
def test_the_sensor_is_measured_as_configured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    options = SensorOptions(preset="dvs128", set=("refractory_us=50", "aps.noise=false"))
    assert execute(Characterise(options, out=tmp_path / "sheet")) == 0
    numbers = json.loads((tmp_path / "sheet" / NUMBERS).read_text())
    assert numbers["asked_for"]["aps"] == {"noise": False}
    period = numbers["sections"]["refractory"]["figures"][0]["measured"]
    assert period == pytest.approx(50.0, rel=0.05)
    text = (tmp_path / "sheet" / PAGE).read_text()
    assert "emulated dvs128, altered" in text
    assert "refractory_us = 50, aps.noise = False" in text
    assert "The dvs128 has no frames" in text
    assert "3 µs *" in text
    assert "of what they give; published for another sensor" in text
    said = capsys.readouterr().out
    assert "DAVIS346" not in said
    assert "3 µs *" in said
    assert "* published for another sensor" in said
    assert numbers["sections"]["refractory"]["figures"][0]["published_for_another_sensor"]


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (
            Characterise(SensorOptions(set=("preset=kodak",)), out=Path("never")),
            ("'kodak'", "davis346"),
        ),
        (Characterise(SensorOptions(set=("theta_on=0",)), out=Path("never")), ("theta_on is 0",)),
        (Characterise(seed=-1, out=Path("never")), ("--seed is -1", "allowed is 0 to")),
    ],
)
def test_bad_input_is_refused_in_a_sentence(
    command: Characterise, words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert execute(command) == 2
    said = capsys.readouterr().err
    assert all(word in said for word in words)
    assert "Traceback" not in said
    assert not Path("never").exists()


@pytest.mark.usefixtures("quick")
def test_a_folder_in_the_way_is_left_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    assert execute(Characterise(out=tmp_path)) == 2
    assert "not written by flybench" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_failed_experiment_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(characterise, "characterise", fail)
    assert execute(Characterise(out=tmp_path / "sheet")) == 130
    assert list(tmp_path.iterdir()) == []


def test_page_is_well_formed_and_needs_nothing_else() -> None:
    text = whole_page()
    tags = Tags()
    tags.feed(text)
    assert tags.open == []
    assert all(link.startswith("#") for link in tags.links)
    assert {link[1:] for link in tags.links} <= tags.names
    assert "Light &lt;on&gt; a card." in text
    assert 'name="viewport"' in text
    assert "3.3 Hz" in text
    assert "+10.0 %" in text
    assert "Somebody 1999" in text


def test_figures_are_svg_and_repeatable() -> None:
    text = draw_svg(PLOT)
    root = ElementTree.fromstring(text)
    assert root.tag.endswith("svg")
    words = "".join(root.itertext())
    for label in ("A & B < C", "light [lux]", "published"):
        assert label in words
    assert draw_svg(PLOT) == text
    assert not re.search(r"\d{4}-\d\d-\d\d", text)


def test_numbers_are_plain_and_finite() -> None:
    made = as_dict(SHEET, changes={"preset": "davis346"}, versions={"numpy": "2"})
    text = json.dumps(made, allow_nan=False)
    one = json.loads(text)["sections"]["one"]
    assert one["plots"][0]["series"][0]["y"] == [1.0, None, 3.0]
    assert one["figures"][0]["difference"] == pytest.approx(0.1)
    assert one["figures"][1]["measured"] is None


def test_numbers_as_people_read_them() -> None:
    assert rows.with_unit(0.1794, "ln units") == "0.179 ln units"
    assert rows.with_unit(2067.3, "Hz") == "2\u202f067 Hz"
    assert rows.with_unit(5.013e-5, "Hz") == "5.01e−05 Hz"
    assert rows.with_unit(-0.0162, "µs") == "−0.0162 µs"
    assert rows.with_unit(0.0, "") == "0"
    assert rows.with_unit(None, "Hz") == rows.NOT_MEASURED
    assert rows.difference(Quantity("a", "", 28.0, Published(3.0, ""))) == "× 9.3"
    assert rows.difference(Quantity("a", "", 2.0, Published(4.0, ""))) == "−50.0 %"
    assert rows.difference(Quantity("a", "dB", 113.2, Published(120.0, ""))) == "−6.8 dB"
    assert rows.difference(Quantity("a", "", 2.9999, Published(3.0, ""))) == "0.0 %"
    assert rows.difference(Quantity("a", "", 2.0)) == ""
    assert rows.difference(Quantity("a", "Hz", 5.01e-5, Published(0.0, ""))) == "+5e−05 Hz"
    assert rows.difference(Quantity("a", "Hz", 0.0, Published(0.0, ""))) == "0.0"
    assert rows.short_source(Quantity("a", "", 2.0, Published(1.0, "Joubert 2021, X"))) == (
        "Joubert 2021"
    )


def test_every_experiment_has_a_place_on_the_sheet() -> None:
    assert len(EXPERIMENTS) >= 9
    assert len({measure.__module__ for measure in EXPERIMENTS.values()}) == len(EXPERIMENTS)
