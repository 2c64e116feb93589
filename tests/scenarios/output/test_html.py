from xml.etree import ElementTree

from scenarios.output.html import card_table, document, inline_svg

SVG = """<?xml version="1.0"?>
<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="9pt"
 height="4pt" viewBox="0 0 9 4">
 <metadata>who</metadata>
 <defs><clipPath id="c"><path id="m" d=""/></clipPath></defs>
 <g clip-path="url(#c)" style="fill: url(#h)"><use xlink:href="#m"/><text>id="c" &lt;#m</text></g>
 <image xlink:href="data:image/png;base64,AA=="/>
</svg>"""


def test_names_inside_a_figure_get_its_prefix_and_nothing_else_does() -> None:
    text = inline_svg(SVG, prefix="one", label='a "b"')
    for words in (
        'id="one-c"',
        'id="one-m"',
        'clip-path="url(#one-c)"',
        "fill: url(#one-h)",
        'href="#one-m"',
        'href="data:image/png;base64,AA=="',
    ):
        assert words in text
    root = ElementTree.fromstring(text)
    assert 'id="c" <#m' in "".join(root.itertext())
    assert root.get("aria-label") == 'a "b"'


def test_a_figure_takes_the_size_that_the_page_gives() -> None:
    root = ElementTree.fromstring(inline_svg(SVG, prefix="one", label=""))
    assert root.get("viewBox") == "0 0 9 4"
    assert root.get("width") is None
    assert "who" not in "".join(root.itertext())


def test_a_page_escapes_its_title_and_a_table_its_heads() -> None:
    assert "<title>a &lt; b</title>" in document("a < b", ["<p>x</p>"])
    table = card_table(("a<b",), [[("name", "<b>x</b>")], [("", "")]])
    assert "<th>a&lt;b</th>" in table
    assert '<td class="name" data-name="a&lt;b"><span><b>x</b></span></td>' in table
    assert '<td class="" data-name="a&lt;b"></td>' in table  # narrow screens leave it out
