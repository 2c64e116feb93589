"""Text from files and other programs, made safe to print."""

from __future__ import annotations

import re

_UNSAFE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufeff]"
)
"""Control characters except tab and line feed, such as the escape character, with which a text can
command a terminal; characters that change the order of others; and half characters, which cannot be
printed at all."""


def printable(text: str) -> str:
    """Return a text with control characters escaped as Python does."""
    return _UNSAFE.sub(lambda found: found[0].encode("unicode_escape").decode(), text)
