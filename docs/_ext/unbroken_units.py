"""A number and its unit stay on one line."""

import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform

UNITS = r"%|px|ms|µs|ns|s|min|lux|klux|Hz|kHz|kB|MB|GB|km/h|m/s|px/s|rad/s|mm|m|µm|dB|MP|B"
SPACE = re.compile(rf"(?<=\d) (?=(?:{UNITS})(?![\w/]))")


class UnbrokenUnits(SphinxTransform):
    """Replace the space between a number and a unit by one that does not break."""

    default_priority = 900

    def apply(self, **_: Any) -> None:
        """Replace them in one document, except in code."""
        for text in list(self.document.findall(nodes.Text)):
            if isinstance(text.parent, nodes.literal | nodes.literal_block | nodes.math):
                continue
            unbroken = SPACE.sub("\u00a0", text)
            if unbroken != text:
                text.parent.replace(text, nodes.Text(unbroken))


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension."""
    app.add_transform(UnbrokenUnits)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
