"""The data sheet as one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from html import escape

from emulator import SensorConfig
from emulator.characterisation import Quantity, Section
from scenarios.datasheet import rows
from scenarios.datasheet.figures import draw_svg

_HEADS = ("figure", "measured", "published", "difference", "source")

_STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 72rem; padding: 1rem; background: #fff; color: #1d2733;
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: .5rem 0 .2rem; }
h2 { font-size: 1.25rem; margin: 2.4rem 0 .4rem; padding-top: .8rem;
  border-top: 2px solid #1d2733; }
p { max-width: 46rem; margin: .4rem 0 .9rem; }
nav { display: flex; flex-wrap: wrap; gap: .3rem .9rem; margin: .8rem 0; }
a { color: #0b5fa5; }
.small { color: #5a6673; font-size: .88rem; }
table { border-collapse: collapse; width: 100%; font-size: .93rem; }
th { text-align: left; font-weight: 600; border-bottom: 2px solid #c9d0d8; padding: .3rem .6rem; }
td { border-bottom: 1px solid #e3e6ea; padding: .35rem .6rem; vertical-align: top; }
td.number { white-space: nowrap; font-variant-numeric: tabular-nums; }
td.measured { font-weight: 600; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr));
  gap: 1rem; margin: 1rem 0; }
figure { margin: 0; }
figure svg { width: 100%; height: auto; max-width: 34rem; }
details { margin: 1rem 0; }
@media (max-width: 44rem) {
  thead { display: none; }
  tr { display: block; padding: .5rem 0; border-bottom: 1px solid #c9d0d8; }
  td { display: flex; gap: .6rem; border: 0; padding: .1rem 0; }
  td::before { content: attr(data-name); flex: 0 0 6rem; color: #5a6673; font-size: .85rem;
    font-weight: 400; }
  td:empty { display: none; }
  td.name { font-weight: 600; }
  td.name .small { font-weight: 400; }
  td.name::before { content: none; }
}
"""


def page(
    sections: Mapping[str, Section],
    *,
    config: SensorConfig,
    preset: str,
    seed: int,
    versions: Mapping[str, str],
) -> str:
    """The whole page.

    Args:
        sections: what the experiments found, by name.
        config: the sensor.
        preset: its name.
        seed: of everything random.
        versions: of the programs that made it.
    """
    title = f"Data sheet of the emulated {preset}"
    programs = ", ".join(f"{name} {number}" for name, number in versions.items())
    body = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="small">{config.width}×{config.height} pixels behind f/{config.f_number:g}; '
        f"seed {seed}; {escape(programs)}.</p>",
        "<p>Measured on the emulator by the experiments with which real event cameras are "
        "characterised. Beside each figure stands what was published of a real sensor, and how "
        "far the emulator is from it. “–” means that this sensor does not show the figure.</p>",
        _navigation(sections),
        *(_section(name, section) for name, section in sections.items()),
        _settings(config),
    ]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(body)
        + "\n</body>\n</html>\n"
    )


def _navigation(sections: Mapping[str, Section]) -> str:
    links = (f'<a href="#{name}">{escape(s.title)}</a>' for name, s in sections.items())
    return f"<nav>{''.join(links)}</nav>"


def _section(name: str, section: Section) -> str:
    figures = "".join(f"<figure>{draw_svg(plot)}</figure>" for plot in section.plots)
    return (
        f'<section id="{name}">\n<h2>{escape(section.title)}</h2>\n'
        f"<p>{escape(section.method)}</p>\n{_table(section.quantities)}\n"
        f'<div class="figures">{figures}</div>\n</section>'
    )


def _table(quantities: Iterable[Quantity]) -> str:
    heads = "".join(f"<th>{head}</th>" for head in _HEADS)
    lines = "\n".join(_row(quantity) for quantity in quantities)
    return f"<table>\n<thead><tr>{heads}</tr></thead>\n<tbody>\n{lines}\n</tbody>\n</table>"


def _row(quantity: Quantity) -> str:
    note = f'<br><span class="small">{escape(quantity.note)}</span>' if quantity.note else ""
    cells = (
        ("name", f"<span>{escape(quantity.name)}{note}</span>"),
        ("number measured", escape(rows.measured(quantity))),
        ("number", escape(rows.published(quantity))),
        ("number", escape(rows.difference(quantity))),
        ("small", escape(rows.source(quantity))),
    )
    made = (
        f'<td class="{kind}" data-name="{head}">{text}</td>'
        for head, (kind, text) in zip(_HEADS, cells, strict=True)
    )
    return f"<tr>{''.join(made)}</tr>"


def _settings(config: SensorConfig) -> str:
    lines = "".join(
        f"<tr><td>{escape(name)}</td><td>{escape(str(value))}</td></tr>"
        for name, value in asdict(config).items()
    )
    return f"<details><summary>All settings of the sensor</summary><table>{lines}</table></details>"
