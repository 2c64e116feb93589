"""HTML pages that need nothing else: one file, readable on a phone, in light and dark."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from xml.etree import ElementTree

_SVG, _LINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"
_STYLE = """
:root { color-scheme: light dark; --paper: #fff; --ink: #1d2733; --faint: #5a6673;
  --line: #c9d0d8; --hair: #e3e6ea; --link: #0b5fa5; }
@media (prefers-color-scheme: dark) {
  :root { --paper: #14181d; --ink: #e6e9ed; --faint: #9aa5b1; --line: #454f5a; --hair: #2b333b;
    --link: #7db8ef; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 72rem; padding: 1rem; background: var(--paper);
  color: var(--ink); font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: .5rem 0 .2rem; }
h2 { font-size: 1.25rem; margin: 2.4rem 0 .4rem; padding-top: .8rem;
  border-top: 2px solid var(--ink); }
p { max-width: 46rem; margin: .4rem 0 .9rem; }
nav { display: flex; flex-wrap: wrap; gap: .3rem .9rem; margin: .8rem 0; }
a { color: var(--link); }
.small { color: var(--faint); font-size: .88rem; }
table { border-collapse: collapse; width: 100%; font-size: .93rem; }
th { text-align: left; font-weight: 600; border-bottom: 2px solid var(--line);
  padding: .3rem .6rem; }
td { border-bottom: 1px solid var(--hair); padding: .35rem .6rem; vertical-align: top; }
td.number { white-space: nowrap; font-variant-numeric: tabular-nums; }
figure { margin: 0; }
figure svg { width: 100%; height: auto; background: #fff; }
details { margin: 1rem 0; }
summary { cursor: pointer; }
"""
_CARDS = """
@media (max-width: 44rem) {
  table.cards thead { display: none; }
  table.cards tr { display: block; padding: .5rem 0; border-bottom: 1px solid var(--line); }
  table.cards td { display: flex; gap: .6rem; border: 0; padding: .1rem 0; }
  table.cards td::before { content: attr(data-name); flex: 0 0 6rem; color: var(--faint);
    font-size: .85rem; font-weight: 400; }
  table.cards td > span { min-width: 0; overflow-wrap: anywhere; }
  table.cards td:empty { display: none; }
  table.cards td.name { font-weight: 600; }
  table.cards td.name .small { font-weight: 400; }
  table.cards td.name::before { content: none; }
}
"""


def document(title: str, body: Iterable[str], *, style: str = "") -> str:
    """A whole page.

    Args:
        title: as text.
        body: its parts, as HTML.
        style: further rules, as CSS.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{_STYLE}{style}{_CARDS}</style>\n</head>\n<body>\n"
        + "\n".join(body)
        + "\n</body>\n</html>\n"
    )


def card_table(heads: Sequence[str], rows: Iterable[Sequence[tuple[str, str]]]) -> str:
    """A table whose rows become cards where the screen is narrow.

    Args:
        heads: of the columns, as text.
        rows: a (class, HTML) a cell; a cell of class "name" heads its card.
    """
    top = "".join(f"<th>{escape(head)}</th>" for head in heads)
    lines = "\n".join(f"<tr>{_cells(heads, row)}</tr>" for row in rows)
    return (
        f'<table class="cards">\n<thead><tr>{top}</tr></thead>\n'
        f"<tbody>\n{lines}\n</tbody>\n</table>"
    )


def _cells(heads: Sequence[str], row: Sequence[tuple[str, str]]) -> str:
    made = []
    for head, (kind, text) in zip(heads, row, strict=True):
        inside = f"<span>{text}</span>" if text else ""
        made.append(f'<td class="{kind}" data-name="{escape(head)}">{inside}</td>')
    return "".join(made)


def inline_svg(text: str, *, prefix: str, label: str) -> str:
    """A figure to stand inside a page beside others.

    Figures name their parts alike, and in one page the first of a name would stand for all; so
    every name gets a prefix. What a page has no use for is left out.

    Args:
        text: a whole SVG file.
        prefix: of all names in it, another for each figure of a page; letters, digits and "-".
        label: what is read out in the figure's place.

    Raises:
        xml.etree.ElementTree.ParseError: it is no XML.
    """
    ElementTree.register_namespace("", _SVG)
    ElementTree.register_namespace("xlink", _LINK)
    root = ElementTree.fromstring(text)
    for metadata in root.findall(f"{{{_SVG}}}metadata"):
        root.remove(metadata)
    for element in root.iter():
        for name, value in element.attrib.items():
            element.set(name, _renamed(name, value, prefix))
    root.set("role", "img")
    root.set("aria-label", label)
    for name in ("width", "height"):  # the page decides; the view box keeps the shape
        root.attrib.pop(name, None)
    return ElementTree.tostring(root, encoding="unicode")


def _renamed(name: str, value: str, prefix: str) -> str:
    if name == "id":
        return f"{prefix}-{value}"
    if name in ("href", f"{{{_LINK}}}href") and value.startswith("#"):
        return f"#{prefix}-{value[1:]}"
    return value.replace("url(#", f"url(#{prefix}-")
