"""The report: verdicts on the claims, figures, numbers, parameters, and how to repeat the study."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from markupsafe import Markup

from scenarios.output.html import inline_svg, render
from scenarios.output.versions import versions
from scenarios.pipeline.registry import study_sensors
from scenarios.study.claims.all_claims import evaluate_claims
from scenarios.study.claims.claim import Claim, Verdict
from scenarios.study.conditions import (
    HIGH_THRESHOLDS,
    moving_background_rows,
    paper_rows,
    second_sensor_rows,
)
from scenarios.study.figures.all_figures import FIGURES, OVERVIEW, draw_figures
from scenarios.study.report.headline import headlines
from scenarios.study.report.parameters import (
    Parameter,
    class_description,
    flatten_parameters,
    method_config,
)
from scenarios.study.report.tables import (
    table_by_background,
    table_by_lighting,
    table_by_sensor,
    table_by_sequence,
)
from scenarios.study.results import STILL, SequenceResult
from scenarios.study.rows import Row
from scenarios.study.statistics import distinct
from scenarios.styles.method_style import in_display_order, method_style

TITLE = "The paper's evaluation, repeated with exact ground truth"
METHODS, COMMAND = "methods", "command"
"""Names in `parameters` with a special meaning: see `write_report`."""
_TEMPLATES = Path(__file__).parent / "templates"
_SYMBOLS: dict[Verdict, str] = {
    "holds": "✓",
    "holds in part": "◐",
    "does not hold": "✗",
    "not tested": "–",
}
_VERBS: dict[Verdict, tuple[str, str]] = {
    "holds": ("holds", "hold"),
    "holds in part": ("holds in part", "hold in part"),
    "does not hold": ("does not hold", "do not hold"),
    "not tested": ("was not tested", "were not tested"),
}


@dataclass(frozen=True)
class _Details:
    """A list of parameters that opens on a click."""

    title: str
    about: str
    parameters: Sequence[Parameter]


def write_report(
    path: Path,
    *,
    sequences: Sequence[SequenceResult],
    rows: Sequence[Row],
    claims: Sequence[Claim],
    parameters: Mapping[str, Any],
    figures: Sequence[Path] | None = None,
    failed: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Write the report.

    Args:
        path: path of the page.
        sequences: one result or more.
        rows: the results of all backgrounds and sensors as a table, see `scenarios.study.rows`.
        claims: verdicts on the paper's claims.
        parameters: parameters of the study by name, as nested mappings, dataclasses or values.
            "command" is the command that repeats the study. "methods" may hold configurations by
            method, where they differ from those of the registry.
        figures: files that `draw_figures` wrote for the same sequences; None: draw them.
        failed: reasons of the methods that failed and are left out, by name.

    Raises:
        OSError: the page cannot be written.
    """
    if figures is None:
        with tempfile.TemporaryDirectory() as folder:
            svgs = _read_svgs(draw_figures(Path(folder), sequences))
    else:
        svgs = _read_svgs(figures)
    methods = in_display_order(distinct(rows, "method"))
    paper, moving, second = paper_rows(rows), moving_background_rows(rows), second_sensor_rows(rows)
    text = render(
        "report.html.j2",
        _TEMPLATES,
        title=TITLE,
        number=len(distinct(paper, "sequence")),
        moving=len(distinct(moving, "sequence")),
        lightings=Counter(one.lighting for one in sequences if one.background == STILL),
        seeds=len(distinct(rows, "seed")),
        slow=list(_slow_methods(methods, len(distinct(rows, "seed")))),
        failed=failed,
        headlines=headlines(paper, claims),
        overview=svgs.pop(OVERVIEW.name, None),
        overview_caption=OVERVIEW.caption,
        claims=claims,
        verdicts=verdict_counts(claims),
        symbols=_SYMBOLS,
        figures=[(figure, svgs[figure.name]) for figure in FIGURES if figure.name in svgs],
        tables=(table_by_lighting(paper), table_by_sequence(paper)),
        background_table=table_by_background(moving) if moving else None,
        sensor_table=table_by_sensor(paper, second) if second else None,
        second=SecondSensor(claims, evaluate_claims(rows, HIGH_THRESHOLDS)),
        second_sensors=len(distinct(second, "seed")),
        details=list(_details(methods, parameters)),
        command=str(parameters.get(COMMAND, "flybench study")),
        programs=[f"{name} {number}" for name, number in versions().items()],
    )
    path.write_text(text, encoding="utf-8")


def _slow_methods(methods: Sequence[str], seeds: int) -> Iterator[str]:
    """Yield a clause for each method that saw fewer sensors than the others."""
    for method in methods:
        if (most := study_sensors(method)) < seeds:
            yield f"{method_style(method).label}: {most:.0f}"


@dataclass(frozen=True)
class SecondSensor:
    """Verdicts on the claims with the sensor of high thresholds, beside those of the default.

    Attributes:
        claims: claims with the default sensor.
        others: the same claims with high thresholds.
    """

    claims: Sequence[Claim]
    others: Sequence[Claim]

    @property
    def tested(self) -> int:
        """Number of claims that both sensors test."""
        return len(list(self._pairs()))

    @property
    def changed(self) -> list[tuple[Claim, Claim]]:
        """Claims with another verdict, each with that of high thresholds."""
        return [(one, other) for one, other in self._pairs() if one.holds != other.holds]

    @property
    def verdicts(self) -> list[tuple[Claim, Claim]]:
        """Claims that both sensors test, those with another verdict first."""
        return sorted(self._pairs(), key=lambda pair: pair[0].holds == pair[1].holds)

    def _pairs(self) -> Iterator[tuple[Claim, Claim]]:
        for one, other in zip(self.claims, self.others, strict=False):
            if "not tested" not in (one.holds, other.holds):
                yield one, other


def verdict_counts(claims: Sequence[Claim]) -> list[str]:
    """Return the number of claims with each verdict that occurs, such as "✓ 2 hold"."""
    counts = Counter(claim.holds for claim in claims)
    return [
        f"{_SYMBOLS[verdict]} {counts[verdict]} {singular if counts[verdict] == 1 else plural}"
        for verdict, (singular, plural) in _VERBS.items()
        if counts[verdict]
    ]


def _read_svgs(files: Sequence[Path]) -> dict[str, Markup]:
    labels = {figure.name: f"{figure.title}. {figure.caption}" for figure in FIGURES}
    return {
        file.stem: inline_svg(
            file.read_text(encoding="utf-8"), prefix=file.stem, label=labels[file.stem]
        )
        for file in files
        if file.suffix == ".svg"
    }


def _details(methods: Sequence[str], parameters: Mapping[str, Any]) -> Iterator[_Details]:
    """Yield the parameters of each method, then those of study, scene and sensor."""
    given = parameters.get(METHODS)
    configs = given if isinstance(given, Mapping) else {}
    for method in methods:
        config = configs.get(method, method_config(method))
        if config is not None:
            about = "" if isinstance(config, Mapping) else class_description(type(config))
            title = method_style(method).label
            yield _Details(title, about, list(flatten_parameters(config)))
    rest = {name: value for name, value in parameters.items() if name not in (METHODS, COMMAND)}
    yield _Details("study, scene and sensor", "", list(flatten_parameters(rest)))
