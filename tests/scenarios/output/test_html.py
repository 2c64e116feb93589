from pathlib import Path
from xml.etree import ElementTree

import pytest
from jinja2 import UndefinedError
from markupsafe import Markup

from scenarios.output.html import inline_svg, render

SVG = """<?xml version="1.0"?>
<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="9pt"
 height="4pt" viewBox="0 0 9 4">
 <metadata>who</metadata>
 <defs><clipPath id="c"><path id="m" d=""/></clipPath></defs>
 <g clip-path="url(#c)" style="fill: url(#h)"><use xlink:href="#m"/><text>id="c" &lt;#m</text></g>
 <image xlink:href="data:image/png;base64,AA=="/>
</svg>"""


def test_only_ids_and_references_get_a_prefix() -> None:
    text = inline_svg(SVG, prefix="one", label='a "b"')
    for part in (
        'id="one-c"',
        'id="one-m"',
        'clip-path="url(#one-c)"',
        "fill: url(#one-h)",
        'href="#one-m"',
        'href="data:image/png;base64,AA=="',
    ):
        assert part in text
    root = ElementTree.fromstring(text)
    assert 'id="c" <#m' in "".join(root.itertext())
    assert root.get("aria-label") == 'a "b"'


def test_the_size_and_the_metadata_of_a_figure_are_removed() -> None:
    root = ElementTree.fromstring(inline_svg(SVG, prefix="one", label=""))
    assert root.get("viewBox") == "0 0 9 4"
    assert root.get("width") is None
    assert "who" not in "".join(root.itertext())


def test_greys_change_with_the_colour_scheme_and_colours_do_not() -> None:
    style = "fill: #ffffff; stroke: #000000; stroke: #d5d8dc; fill: #00A884"
    text = inline_svg(SVG.replace("fill: url(#h)", style), prefix="one", label="")
    assert "fill: color-mix(in srgb, var(--ink) 0%, var(--paper));" in text
    assert "stroke: color-mix(in srgb, var(--ink) 100%, var(--paper));" in text
    assert "var(--ink) 15%" in text
    assert "fill: #00A884" in text


def test_a_page_escapes_text_but_not_markup(tmp_path: Path) -> None:
    source = '{% extends "page.html.j2" %}{% block body %}{{ text }} {{ note|code }}{% endblock %}'
    (tmp_path / "own.html.j2").write_text(source)
    values = {"text": Markup("<b>x</b>"), "note": "`a` < b"}
    page = render("own.html.j2", tmp_path, title="a < b", **values)
    assert "<title>a &lt; b</title>" in page
    assert "<b>x</b> <code>a</code> &lt; b" in page


def test_an_empty_cell_stays_empty(tmp_path: Path) -> None:
    source = """{% from "macros.html.j2" import cell %}
{{ cell("a<b", "x", "name", "note") }}{{ cell("c", "") }}"""
    (tmp_path / "own.html.j2").write_text(source)
    html = render("own.html.j2", tmp_path)
    assert '<td class="name" data-name="a&lt;b"><span>x<br>' in html
    assert '<td class="" data-name="c"></td>' in html  # a narrow screen leaves it out


def test_a_missing_value_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "own.html.j2").write_text("{{ nothing }}")
    with pytest.raises(UndefinedError, match="nothing"):
        render("own.html.j2", tmp_path)
