import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
from markupsafe import escape

from scenarios.pipeline.registry import CONTRAST, FLY, FLY_EVERYWHERE, FRAME_FLY, SPIKING
from scenarios.study.claims.all_claims import evaluate_claims
from scenarios.study.claims.claim import Claim
from scenarios.study.claims.small_table import SmallTable
from scenarios.study.conditions import HIGH_THRESHOLDS
from scenarios.study.figures.all_figures import FIGURES, draw_figures
from scenarios.study.report.page import SecondSensor, verdict_counts, write_report
from scenarios.study.rows import study_rows
from sim import CrossingConfig
from tests.scenarios.study.synthetic_results import make_run, make_sequence

OWN = "my.<own>:Detector"
TABLE = SmallTable("mean response", "rad/s", ("1.21",), (("fly", ("80",)),))
CLAIMS = [
    Claim("Events beat frames.", "Section III", "holds", "0.9 > 0.1 & more"),
    Claim("GRMS rises", "Fig. EX3 B", "holds in part", "in <two> of three seeds", (TABLE,)),
    Claim("It costs less", "Fig. EX3 D", "does not hold", "it costs 3 ms"),
    Claim("It runs on an M4", "Section III", "not tested", "another machine"),
]
VOID = {"meta", "br", "image", "path", "use", "rect"}


def html(text: str) -> str:
    """Escape text as the templates do."""
    return str(escape(text))


class Page(HTMLParser):
    """Collects ids and links, and checks that each element is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.ids: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
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
                self.ids.append(value)

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag


@pytest.fixture(scope="module")
def text(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("report")
    methods = (FLY, FRAME_FLY, CONTRAST, OWN)
    sequences = [
        make_sequence("day", methods=methods),
        make_sequence("night", 1.07, methods=methods),
    ]
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
        failed={"bees:Bee": "bees:Bee: no <wind>"},
    )
    return (folder / "report.html").read_text(encoding="utf-8")


def test_the_page_is_well_formed_and_self_contained(text: str) -> None:
    page = Page(text)
    assert page.open == []
    assert all(link.startswith(("#", "data:image/png;base64,")) for link in page.links)
    assert not re.search(r"url\((?!#)|@import|<script|<link", text)
    assert 'name="viewport"' in text
    assert len(text) < 5e6


def test_ids_are_unique_and_every_reference_has_a_target(text: str) -> None:
    page = Page(text)
    assert len(page.ids) == len(set(page.ids))
    used = {link[1:] for link in page.links if link.startswith("#")}
    used |= set(re.findall(r"url\(#([^)]*)\)", text))
    assert used <= set(page.ids)
    assert used


def test_the_page_has_claims_then_figures_then_numbers(text: str) -> None:
    shown = [figure for figure in FIGURES if not figure.is_moving]
    assert text.count("<svg") == len(shown)
    order = [text.index(f'id="{name}"') for name in ("claims", "figures", "numbers", "parameters")]
    assert text.index('class="headlines"') < text.index("<svg") < order[0]
    assert order == sorted(order)
    for claim in CLAIMS:
        for part in (claim.statement, claim.where, claim.evidence, claim.holds):
            assert html(part) in text
    for figure in shown:
        assert html(figure.caption) in text


def test_data_is_escaped(text: str) -> None:
    for raw in ("<two>", "<own>", "<wind>", "<script>", "'a & b'"):
        assert raw not in text
        assert html(raw) in text


def test_the_page_has_numbers_and_parameters(text: str) -> None:
    assert "2.01 to 5.99" not in text
    assert "1.52 to 6.48" in text  # velocity errors of 3, 4 and 5 px/s
    assert "crossing.omega_rad_s" in text
    assert "Table I" in text  # from the docstring of the fly's configuration
    assert "numba" in text


def test_the_page_opens_with_three_numbers_and_counts_the_claims(text: str) -> None:
    for number in ("<dt>1 of 3</dt>", "<dt>100 %</dt>", "<dt>1.18 ms</dt>"):
        assert number in text
    assert "This study examines 4 claims" in text
    assert "✓ 1 holds, ◐ 1 holds in part, ✗ 1 does not hold, – 1 was not tested." in text


def test_numbers_of_a_claim_are_a_small_table(text: str) -> None:
    table = text[text.index('<table class="evidence">') :].split("</table>")[0]
    assert "<caption>mean response</caption>" in table
    assert "<th>rad/s</th><th>1.21</th>" in table
    assert '<tr><th>fly</th><td class="number">80</td></tr>' in table


def test_figures_are_drawn_if_none_are_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("scenarios.study.figures.all_figures.FIGURES", FIGURES[3:4])
    sequences = [make_sequence(methods=(FLY,), seeds=(0,))]
    path = tmp_path / "report.html"
    write_report(path, sequences=sequences, rows=study_rows(sequences), claims=[], parameters={})
    text = path.read_text(encoding="utf-8")
    assert text.count("<svg") == 1
    assert "examines no claim" in text
    assert list(tmp_path.iterdir()) == [path]


def test_claims_are_counted_by_verdict() -> None:
    assert verdict_counts([CLAIMS[0], CLAIMS[2], CLAIMS[0]]) == ["✓ 2 hold", "✗ 1 does not hold"]
    assert verdict_counts([]) == []


def test_moving_backgrounds_and_the_second_sensor_have_a_table_each(tmp_path: Path) -> None:
    second = [
        replace(make_run(method, seed, hs=-0.5), sensor=HIGH_THRESHOLDS)
        for method in (FLY, CONTRAST)
        for seed in (0, 1)
    ]
    paper = make_sequence("day", methods=(FLY, CONTRAST, SPIKING))
    sequences = [
        replace(paper, runs=(*paper.runs, *second)),
        make_sequence("day", 1.61, background="wind", methods=(FLY, FLY_EVERYWHERE)),
    ]
    path = tmp_path / "report.html"
    rows = study_rows(sequences)
    claims = evaluate_claims(rows)
    write_report(path, sequences=sequences, rows=rows, claims=claims, parameters={})
    text = " ".join(path.read_text(encoding="utf-8").split())
    page = Page(text)
    assert {"background", "sensor"} < set(page.ids)
    assert "1 crossing (day: 1)" in text
    assert "and 1 with a moving background" in text
    assert "wind: correct steps [%]" in text
    assert "event-driven fly, no attention" in text
    assert "seen by 2 sensors with thresholds of 0.4" in text
    assert "day, high thresholds: correct steps [%]" in text
    changed = re.findall('<tr class="changed">.*?</tr>', text)
    finds = "the event-driven fly finds the correct direction in every sequence"
    (row,) = (part for part in changed if finds in part)
    assert row.index("✓ holds") < row.index("✗ does not hold")
    assert "Number of sensors of the slow ones: spiking delays: 1." in text


def test_claims_that_a_sensor_cannot_test_are_not_compared() -> None:
    one, other = CLAIMS[0], replace(CLAIMS[0], holds="does not hold")
    untested = CLAIMS[3]
    pair = SecondSensor([one, one, untested], [one, other, other])
    assert (pair.tested, pair.changed) == (2, [(one, other)])
    assert pair.verdicts == [(one, other), (one, one)]
