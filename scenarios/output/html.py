"""Self-contained HTML pages, rendered from Jinja2 templates.

Every page extends `templates/page.html.j2`. The templates of a page are in the folder `templates`
beside the module that renders it.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

_TEMPLATES = Path(__file__).parent / "templates"
_GREY_SPREAD = 24
"""Largest difference of red, green and blue in a colour that counts as grey (assumed)."""
_SVG, _XLINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"


def render(template: str, folder: Path, **values: Any) -> str:
    """Render a page.

    Args:
        template: file name of the template.
        folder: folder of the template.
        values: values that the template uses; text is escaped, `Markup` is not.

    Raises:
        jinja2.UndefinedError: the template uses a value that is not given.
    """
    environment = Environment(
        loader=FileSystemLoader([folder, _TEMPLATES]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["code"] = code
    return environment.get_template(template).render(values)


def code(text: str) -> Markup:
    """Escape text and mark up the words between backticks as code."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text))))


def inline_svg(text: str, *, prefix: str, label: str) -> Markup:
    """Prepare an SVG file for use inside a page with other figures.

    Figures use the same ids, and within a page the first element with an id would serve all
    figures, so every id gets a prefix. Metadata and the size are removed; the page sets the size.
    Black, white and greys become shades between the page's ink and paper, so that they change with
    the colour scheme of the reader; other colours and images stay as they are.

    Args:
        text: a whole SVG file.
        prefix: prefix for all ids, different for each figure of a page; letters, digits and "-".
        label: text for screen readers.

    Raises:
        xml.etree.ElementTree.ParseError: the text is not XML.
    """
    ElementTree.register_namespace("", _SVG)
    ElementTree.register_namespace("xlink", _XLINK)
    root = ElementTree.fromstring(text)
    for metadata in root.findall(f"{{{_SVG}}}metadata"):
        root.remove(metadata)
    for element in root.iter():
        for name, value in element.attrib.items():
            element.set(name, _with_prefix(name, value, prefix))
        if "style" in element.attrib:
            element.set("style", _themed(element.attrib["style"]))
    root.set("role", "img")
    root.set("aria-label", label)
    for name in ("width", "height"):
        root.attrib.pop(name, None)
    return Markup(ElementTree.tostring(root, encoding="unicode"))


def _themed(style: str) -> str:
    """Replace greys by mixtures of the page's colours of ink and paper."""
    return re.sub("#[0-9a-fA-F]{6}", lambda found: _mixture(found[0]), style)


def _mixture(colour: str) -> str:
    parts = bytes.fromhex(colour[1:])
    if max(parts) - min(parts) > _GREY_SPREAD:
        return colour
    ink = round(100 * (1 - sum(parts) / (3 * 255)))
    return f"color-mix(in srgb, var(--ink) {ink}%, var(--paper))"


def _with_prefix(name: str, value: str, prefix: str) -> str:
    if name == "id":
        return f"{prefix}-{value}"
    if name in ("href", f"{{{_XLINK}}}href") and value.startswith("#"):
        return f"#{prefix}-{value[1:]}"
    return value.replace("url(#", f"url(#{prefix}-")
