"""The data sheet as one self-contained HTML page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

from emulator.characterisation import Datasheet, Quantity, Section
from emulator.presets import WITHOUT_FRAMES
from scenarios.datasheet import formatting
from scenarios.datasheet.digest import digest
from scenarios.datasheet.explanations import note
from scenarios.datasheet.figures import draw_svg
from scenarios.output.html import inline_svg, render

_TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True)
class _Row:
    """One row of a table, as text."""

    name: str
    note: str
    measured: str
    published: str
    difference: str
    source: str


@dataclass(frozen=True)
class _Section:
    """One experiment: id of its section, texts, table rows and figures."""

    name: str
    title: str
    method: str
    rows: Sequence[_Row]
    figures: Sequence[Markup]


def render_page(
    sheet: Datasheet, *, changes: Mapping[str, Any], versions: Mapping[str, str]
) -> str:
    """Render the page.

    Args:
        sheet: results of the experiments.
        changes: preset of the sensor and its changed settings, by name.
        versions: versions of the programs used, by name.
    """
    preset, summary = str(changes["preset"]), digest(sheet)
    changed = {name: value for name, value in changes.items() if name != "preset"}
    return render(
        "datasheet.html.j2",
        _TEMPLATES,
        title=f"Data sheet of the emulated {preset}{', modified' if changed else ''}",
        config=sheet.config,
        seed=sheet.seed,
        programs=", ".join(f"{name} {number}" for name, number in versions.items()),
        changes=", ".join(f"{name} = {value}" for name, value in _flat(changed)),
        footnote=formatting.footnote(sheet),
        preset=preset,
        without_frames=preset in WITHOUT_FRAMES,
        sections=[_section(name, section) for name, section in sheet.sections.items()],
        digest=summary,
        key_figures=[(one, _row(one.quantity)) for one in summary.key_figures],
        settings=list(_flat(asdict(sheet.config))),
    )


def _section(name: str, section: Section) -> _Section:
    figures = [
        inline_svg(draw_svg(plot), prefix=f"{name}-{number}", label=plot.title)
        for number, plot in enumerate(section.plots)
    ]
    pairs = zip([None, *section.quantities], section.quantities, strict=False)
    rows = [_row(quantity, before) for before, quantity in pairs]
    return _Section(name, section.title, section.method, rows, figures)


def _row(quantity: Quantity, before: Quantity | None = None) -> _Row:
    return _Row(
        quantity.name,
        note(quantity, before),
        formatting.measured(quantity),
        formatting.published(quantity),
        formatting.difference(quantity),
        formatting.source(quantity),
    )


def _flat(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield nested values by their dotted names, such as "aps.exposure_us"."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value
