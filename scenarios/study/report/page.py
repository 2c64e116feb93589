"""The study as one HTML file: what holds, the figures, the numbers, and how to run it again."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from scenarios.output.html import card_table, document, inline_svg
from scenarios.pipeline.summary import versions
from scenarios.study import results
from scenarios.study.claims.claim import Claim, Verdict
from scenarios.study.figures.all_figures import FIGURES, Figure, draw_figures
from scenarios.study.figures.method_style import in_order, method_style
from scenarios.study.report.parameters import flat, method_config, opening
from scenarios.study.report.tables import table_by_light, table_by_sequence
from scenarios.study.rows import Row
from scenarios.study.statistics import each

TITLE = "The paper's evaluation, run again beside exact truth"
METHODS, COMMAND = "methods", "command"
"""Names in `parameters` that the page knows: see `write_report`."""
_MARKS: dict[Verdict, str] = {
    "holds": "✓ holds",
    "holds in part": "◐ holds in part",
    "does not hold": "✗ does not hold",
    "not tested": "– not tested",
}
_VERBS: dict[Verdict, tuple[str, str]] = {
    "holds": ("holds", "hold"),
    "holds in part": ("holds in part", "hold in part"),
    "does not hold": ("does not hold", "do not hold"),
    "not tested": ("was not tested", "were not tested"),
}
_STYLE = """
.lead { font-size: 1.08rem; max-width: 52rem; }
.wide { overflow-x: auto; border: 1px solid var(--hair); margin: .8rem 0; }
.figure { overflow-x: auto; margin: .6rem 0; background: #fff; }
.figure svg { display: block; min-width: 40rem; max-width: 62rem; margin: 0 auto; }
figcaption { max-width: 52rem; font-size: .93rem; margin: .4rem 0 1.6rem; }
h3 { font-size: 1.05rem; margin: 1.8rem 0 .2rem; }
td.verdict { white-space: nowrap; font-weight: 600; }
table.numbers { font-size: .85rem; }
table.numbers th { vertical-align: bottom; min-width: 5.2rem; }
table.numbers th:first-child { min-width: 8.5rem; }
table.numbers th .small { font-weight: 400; }
table.numbers tbody th { position: sticky; left: 0; background: var(--paper);
  border-bottom: 1px solid var(--hair); vertical-align: top; }
td.value > span { font-family: ui-monospace, monospace; overflow-wrap: anywhere; }
pre { overflow-x: auto; border: 1px solid var(--hair); padding: .6rem; }
"""


def write_report(
    path: Path,
    *,
    sequences: Sequence[results.Sequence],
    rows: Sequence[Row],
    claims: Sequence[Claim],
    parameters: Mapping[str, Any],
    figures: Sequence[Path] | None = None,
) -> None:
    """Write the report.

    Args:
        path: of the page.
        sequences: what the study found, one at least.
        rows: the same as a table, see `scenarios.study.rows`.
        claims: the paper's, held against it.
        parameters: of the study, by name, nested as they come: mappings, dataclasses or values.
            "command" is what to type to run it again; "methods" may hold the configuration of a
            method by its name, where it is not the method's own.
        figures: the files that `draw_figures` wrote of the same sequences; drawn anew where None.

    Raises:
        OSError: it cannot be written.
    """
    if figures is None:
        with tempfile.TemporaryDirectory() as folder:
            drawn = _read_svgs(draw_figures(Path(folder), sequences))
    else:
        drawn = _read_svgs(figures)
    body = [
        f"<h1>{escape(TITLE)}</h1>",
        _scope(sequences, rows),
        f'<p class="lead">{what_holds(claims)}</p>',
        _claims(claims),
        '<h2 id="figures">Figures</h2>',
        *(_figure(figure, drawn[figure.name]) for figure in FIGURES if figure.name in drawn),
        *_tables(rows),
        *_parameters(rows, parameters),
        *_again(parameters),
    ]
    path.write_text(document(TITLE, body, style=_STYLE), encoding="utf-8")


def what_holds(claims: Sequence[Claim]) -> str:
    """A paragraph, as HTML, that says which claims hold, which in part, and which do not."""
    if not claims:
        return "No claim of the paper is looked at here."
    noun = "claim" if len(claims) == 1 else "claims"
    told = [f"Of the {len(claims)} {noun} of the paper that are looked at here,"]
    for verdict, (one, many) in _VERBS.items():
        own = [claim.statement.rstrip(". ") for claim in claims if claim.holds == verdict]
        if own:
            verb = one if len(own) == 1 else many
            told.append(f"<b>{len(own)} {verb}:</b> {escape('; '.join(own))}.")
    return " ".join(told)


def _scope(sequences: Sequence[results.Sequence], rows: Sequence[Row]) -> str:
    seeds = len(each(rows, "seed"))
    methods = "; ".join(method_style(m).label for m in in_order(each(rows, "method")))
    lights = [
        f"{sum(one.lighting == light for one in sequences)} by {light}"
        for light in dict.fromkeys(one.lighting for one in sequences)
    ]
    return (
        f'<p class="small">{len(sequences)} crossings ({escape(", ".join(lights))}), each seen by '
        f"{seeds} sensor{'s' if seeds != 1 else ''} with seeds of their own; methods: "
        f"{escape(methods)}. Light, sensor and truth are simulated.</p>"
    )


def _claims(claims: Sequence[Claim]) -> str:
    heads = ("claim", "in the paper", "here", "evidence")
    lines = (
        (
            ("name", escape(claim.statement)),
            ("small", escape(claim.where)),
            ("verdict", escape(_MARKS[claim.holds])),
            ("", escape(claim.evidence)),
        )
        for claim in claims
    )
    return f'<h2 id="claims">Claims</h2>\n{card_table(heads, lines)}'


def _read_svgs(files: Sequence[Path]) -> dict[str, str]:
    return {file.stem: file.read_text(encoding="utf-8") for file in files if file.suffix == ".svg"}


def _figure(figure: Figure, svg: str) -> str:
    drawn = inline_svg(svg, prefix=figure.name, label=f"{figure.title}. {figure.caption}")
    return (
        f"<h3>{escape(figure.title)}</h3>\n<figure>\n"
        f'<div class="figure" tabindex="0">{drawn}</div>\n'
        f"<figcaption><b>{escape(figure.counterpart)}.</b> "
        f"{escape(figure.caption)}</figcaption>\n</figure>"
    )


_ABOUT_NUMBERS = (
    "Mean and 95 % interval over the seeds (Student's t, one value a seed). The interval holds for "
    "other sensors before the same scene, not for other scenes. Where a part of the runs lacks a "
    "figure, such as a latency where no step was right, the number that has it stands below. “–”: "
    "no run has it."
)
_ABOUT_PARAMETERS = (
    "Each names its source, or says that it is assumed; where a value was found by trial, it says "
    "on what. None was chosen on the velocities that the methods are judged on."
)


def _tables(rows: Sequence[Row]) -> Iterator[str]:
    yield f'<h2 id="numbers">Numbers</h2>\n<p>{escape(_ABOUT_NUMBERS)}</p>'
    yield table_by_light(rows)
    yield f"<details><summary>By sequence</summary>{table_by_sequence(rows)}</details>"


def _parameters(rows: Sequence[Row], parameters: Mapping[str, Any]) -> Iterator[str]:
    yield f'<h2 id="parameters">Parameters</h2>\n<p>{escape(_ABOUT_PARAMETERS)}</p>'
    given = parameters.get(METHODS)
    configs = dict(given) if isinstance(given, Mapping) else {}
    for method in in_order(each(rows, "method")):
        config = configs.get(method, method_config(method))
        if config is not None:
            about = "" if isinstance(config, Mapping) else opening(type(config))
            yield _details(method_style(method).label, about, config)
    rest = {name: value for name, value in parameters.items() if name not in (METHODS, COMMAND)}
    yield _details("the study, the street and the sensor", "", rest)


def _details(name: str, about: str, values: Any) -> str:
    lines = (
        (
            ("name", escape(one.name)),
            ("value", escape(one.value)),
            ("small", _code(escape(one.note))),
        )
        for one in flat(values)
    )
    table = card_table(("parameter", "value", "meaning and source"), lines)
    return (
        f"<details><summary>{escape(name)}</summary>\n"
        f"<p>{_code(escape(about))}</p>\n{table}</details>"
    )


def _code(text: str) -> str:
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", text)


def _again(parameters: Mapping[str, Any]) -> Iterator[str]:
    command = str(parameters.get(COMMAND, "flybench study"))
    yield (
        '<h2 id="again">Run it again</h2>\n<p>The same command with the same versions gives the '
        f"same events and decisions; only times differ.</p>\n<pre>{escape(command)}</pre>"
    )
    yield (
        "<p>Beside this page lie the table with a row a crossing, method and seed, the figures as "
        "SVG and PNG, and, unless they were left out, recordings, which <code>flybench view</code> "
        "opens.</p>"
    )
    programs = ", ".join(f"{name} {number}" for name, number in versions().items())
    yield f'<p class="small">Made with {escape(programs)}.</p>'
