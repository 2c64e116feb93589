"""Docstrings are plain text: signs that reStructuredText would interpret are shown as they are."""

import re
from typing import Any

from sphinx.application import Sphinx

SIGNS = re.compile(r"[|*]|(?<=\w)_(?!\w)")


def escape(
    _app: Sphinx, _what: str, _name: str, _object: Any, _options: Any, lines: list[str]
) -> None:
    """Escape the signs outside of backticks, before napoleon reads the sections."""
    for k, line in enumerate(lines):
        parts = line.split("`")
        parts[::2] = [SIGNS.sub(r"\\\g<0>", part) for part in parts[::2]]
        lines[k] = "`".join(parts)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension."""
    app.connect("autodoc-process-docstring", escape, priority=400)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
