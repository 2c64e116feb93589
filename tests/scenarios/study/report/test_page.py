import re
from dataclasses import replace
from html import escape
from html.parser import HTMLParser
from pathlib import Path

import pytest

from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY
from scenarios.study.claims.claim import Claim
from scenarios.study.figures.all_figures import FIGURES, draw_figures
from scenarios.study.report.page import what_holds, write_report
from scenarios.study.rows import study_rows
from sim import CrossingConfig
from tests.scenarios.study.hand_made import a_sequence

OWN = "my.<own>:Detector"
CLAIMS = [
    Claim("Events beat frames.", "Section III", "holds", "0.9 > 0.1 & more"),
    Claim("GRMS rises", "Fig. EX3 B", "holds in part", "in <two> of three seeds"),
    Claim("It costs less", "Fig. EX3 D", "does not hold", "it costs 3 ms"),
    Claim("It runs on an M4", "Section III", "not tested", "another machine"),
]
EMPTY = {"meta", "br", "image", "path", "use", "rect"}


class Page(HTMLParser):
    """Collects names and links, and checks that each element closes."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.names: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in EMPTY:
            self.open.append(tag)
        self.note(attrs)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag
        self.note(attrs)

    def note(self, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in {"src", "href", "xlink:href"} and value is not None:
                self.links.append(value)
            if name == "id" and value is not None:
                self.names.append(value)

    def handle_endtag(self, tag: str) -> None:
        if tag not in EMPTY:
            assert self.open.pop() == tag


@pytest.fixture(scope="module")
def text(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("report")
    methods = (FLY, FRAME_FLY, CONTRAST, OWN)
    sequences = [a_sequence("day", methods=methods), a_sequence("night", 1.07, methods=methods)]
    write_report(
        folder / "report.html",
        sequences=sequences,
        rows=study_rows(sequences),
        claims=CLAIMS,
        parameters={
            "command": "flybench study --out 'a & b'",
            "note": "<script>",
            "crossing": CrossingConfig(),
        },
        figures=draw_figures(folder, sequences),
    )
    return (folder / "report.html").read_text(encoding="utf-8")


def test_page_is_well_formed_and_needs_nothing_else(text: str) -> None:
    page = Page(text)
    assert page.open == []
    assert all(link.startswith(("#", "data:image/png;base64,")) for link in page.links)
    assert not re.search(r"url\((?!#)|@import|<script|<link", text)
    assert 'name="viewport"' in text
    assert len(text) < 5e6


def test_names_of_the_figures_do_not_collide_and_all_that_is_named_is_there(text: str) -> None:
    page = Page(text)
    assert len(page.names) == len(set(page.names))
    used = {link[1:] for link in page.links if link.startswith("#")}
    used |= set(re.findall(r"url\(#([^)]*)\)", text))
    assert used <= set(page.names)
    assert used


def test_claims_come_first_then_figures_then_numbers(text: str) -> None:
    assert text.count("<svg") == len(FIGURES)
    order = [text.index(f'id="{name}"') for name in ("claims", "figures", "numbers", "parameters")]
    assert text.index('class="lead"') < order[0]
    assert order == sorted(order)
    for claim in CLAIMS:
        for words in (claim.statement, claim.where, claim.evidence, claim.holds):
            assert escape(words) in text
    for figure in FIGURES:
        assert escape(figure.counterpart) in text


def test_data_is_escaped(text: str) -> None:
    for raw in ("<two>", "<own>", "<script>", "'a & b'"):
        assert raw not in text
        assert escape(raw) in text


def test_numbers_and_parameters_are_there(text: str) -> None:
    assert "2.01 to 5.99" not in text
    assert "1.52 to 6.48" in text  # velocity errors of 3, 4 and 5 px/s
    assert "crossing.omega_rad_s" in text
    assert "Table I" in text  # what the fly's configuration says of itself
    assert "numba" in text


def test_figures_are_drawn_where_none_are_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("scenarios.study.figures.all_figures.FIGURES", FIGURES[2:3])
    sequences = [a_sequence(methods=(FLY,), seeds=(0,))]
    path = tmp_path / "report.html"
    write_report(path, sequences=sequences, rows=study_rows(sequences), claims=[], parameters={})
    assert path.read_text(encoding="utf-8").count("<svg") == 1
    assert list(tmp_path.iterdir()) == [path]


def test_paragraph_says_what_holds_and_what_does_not() -> None:
    words = what_holds(CLAIMS)
    assert words.startswith("Of the 4 claims of the paper")
    for part in (
        "<b>1 holds:</b> Events beat frames.",
        "<b>1 holds in part:</b> GRMS rises.",
        "<b>1 does not hold:</b> It costs less.",
        "<b>1 was not tested:</b> It runs on an M4.",
    ):
        assert part in words
    twice = what_holds([replace(CLAIMS[0], statement="a < b")] * 2)
    assert "<b>2 hold:</b> a &lt; b; a &lt; b." in twice
    assert what_holds([]) == "No claim of the paper is looked at here."
