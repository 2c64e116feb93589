"""Text from files and other programs, made safe to print, and to show in a notebook."""

from __future__ import annotations

import html
import re
from collections.abc import Mapping

_UNSAFE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufeff]"
)
"""Control characters except tab and line feed, such as the escape character, with which a text can
command a terminal; characters that change the order of others; and half characters, which cannot be
printed at all."""


def printable(text: str) -> str:
    """Return a text with control characters escaped as Python does."""
    return _UNSAFE.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def html_table(title: str, rows: Mapping[str, object]) -> str:
    """Return a table of names and values in HTML, for the output of a notebook's cell."""
    lines = "".join(
        f"<tr><th style='text-align: left'>{_escaped(name)}</th>"
        f"<td style='text-align: left'>{_escaped(value)}</td></tr>"
        for name, value in rows.items()
    )
    caption = f"<caption style='text-align: left'><b>{_escaped(title)}</b></caption>"
    return f"<table>{caption}<tbody>{lines}</tbody></table>"


def _escaped(value: object) -> str:
    return html.escape(printable(str(value)))
