"""The data sheet as one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from html import escape
from typing import Any

from emulator import SensorConfig
from emulator.characterisation import Datasheet, Quantity, Section
from emulator.presets import WITHOUT_FRAMES
from scenarios.datasheet import rows
from scenarios.datasheet.figures import draw_svg
from scenarios.output.html import card_table, document, inline_svg

_HEADS = ("figure", "measured", "published", "difference", "source")

_STYLE = """
td.measured { font-weight: 600; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr));
  gap: 1rem; margin: 1rem 0; }
figure svg { max-width: 34rem; }
"""


def page(sheet: Datasheet, *, changes: Mapping[str, Any], versions: Mapping[str, str]) -> str:
    """The whole page.

    Args:
        sheet: what was measured.
        changes: what makes the sensor, its preset included.
        versions: of the programs that made it.
    """
    config = sheet.config
    altered = {name: value for name, value in changes.items() if name != "preset"}
    title = f"Data sheet of the emulated {changes['preset']}{', altered' if altered else ''}"
    programs = ", ".join(f"{name} {number}" for name, number in versions.items())
    body = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="small">{config.width}×{config.height} pixels behind f/{config.f_number:g}; '
        f"seed {sheet.seed}; {escape(programs)}.</p>",
        _alterations(altered),
        "<p>Measured on the emulator by the experiments with which real event cameras are "
        "characterised. Beside each figure stands what was published of a real sensor, and how "
        "far the emulator is from it. “–” means that this sensor does not show the figure. Where a "
        "default of the emulator was set from the published figure, its source says so: to meet it "
        "proves the experiment, not the model.</p>",
        _foreign(sheet),
        _frameless(str(changes["preset"])),
        _navigation(sheet.sections),
        *(_section(name, section) for name, section in sheet.sections.items()),
        _settings(config),
    ]
    return document(title, body, style=_STYLE)


def _alterations(altered: Mapping[str, Any]) -> str:
    """What was asked for beyond the preset; nothing where that was nothing."""
    if not altered:
        return ""
    values = ", ".join(f"{name} = {value}" for name, value in _flat(altered))
    return f"<p>Altered: {escape(values)}.</p>"


def _foreign(sheet: Datasheet) -> str:
    """What the mark beside figures of other sensors means; nothing where there are none."""
    return f"<p>{escape(text)}</p>" if (text := rows.footnote(sheet)) else ""


def _frameless(name: str) -> str:
    """That the chip has no frames; nothing where it has."""
    if name not in WITHOUT_FRAMES:
        return ""
    return (
        f"<p>The {escape(name)} has no frames: the sheet leaves them out, and the settings aps.* "
        "mean nothing.</p>"
    )


def _navigation(sections: Mapping[str, Section]) -> str:
    links = (f'<a href="#{name}">{escape(s.title)}</a>' for name, s in sections.items())
    return f"<nav>{''.join(links)}</nav>"


def _section(name: str, section: Section) -> str:
    drawn = (
        inline_svg(draw_svg(plot), prefix=f"{name}-{number}", label=plot.title)
        for number, plot in enumerate(section.plots)
    )
    figures = "".join(f"<figure>{svg}</figure>" for svg in drawn)
    return (
        f'<section id="{name}">\n<h2>{escape(section.title)}</h2>\n'
        f"<p>{escape(section.method)}</p>\n{_table(section.quantities)}\n"
        f'<div class="figures">{figures}</div>\n</section>'
    )


def _table(quantities: Iterable[Quantity]) -> str:
    return card_table(_HEADS, map(_row, quantities))


def _row(quantity: Quantity) -> tuple[tuple[str, str], ...]:
    note = f'<br><span class="small">{escape(quantity.note)}</span>' if quantity.note else ""
    return (
        ("name", f"{escape(quantity.name)}{note}"),
        ("number measured", escape(rows.measured(quantity))),
        ("number", escape(rows.published(quantity))),
        ("number", escape(rows.difference(quantity))),
        ("small", escape(rows.source(quantity))),
    )


def _settings(config: SensorConfig) -> str:
    lines = "".join(
        f"<tr><td>{escape(name)}</td><td>{escape(str(value))}</td></tr>"
        for name, value in _flat(asdict(config))
    )
    return f"<details><summary>All settings of the sensor</summary><table>{lines}</table></details>"


def _flat(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Values by dotted names, such as "aps.exposure_us"."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value
