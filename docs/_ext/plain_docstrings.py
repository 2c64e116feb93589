"""Docstrings are plain text: signs that reStructuredText would interpret are shown as they are."""

import re
from typing import Any

from sphinx.application import Sphinx
from sphinx.ext.napoleon import GoogleDocstring

SIGNS = re.compile(r"[|*]|(?<=\w)_(?!\w)")


def escape(
    _app: Sphinx, _what: str, _name: str, _object: Any, _options: Any, lines: list[str]
) -> None:
    """Escape the signs outside of backticks, before napoleon reads the sections."""
    for k, line in enumerate(lines):
        parts = line.split("`")
        parts[::2] = [SIGNS.sub(r"\\\g<0>", part) for part in parts[::2]]
        lines[k] = "`".join(parts)


def _whole_attribute(docstring: GoogleDocstring) -> tuple[str, list[str]]:
    """Return no type and the whole text: napoleon takes what stands before a colon for a type."""
    return "", docstring._dedent(docstring._consume_to_end())


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension."""
    GoogleDocstring._consume_inline_attribute = _whole_attribute  # type: ignore[method-assign]
    app.connect("autodoc-process-docstring", escape, priority=400)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
