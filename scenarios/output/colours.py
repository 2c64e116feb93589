"""The colours of ON and OFF events, the same in every figure, page, recording and film."""

from __future__ import annotations

from typing import Final

Rgb = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""

ON: Final[Rgb] = (0, 114, 178)
OFF: Final[Rgb] = (213, 94, 0)
"""Blue and vermilion, which colour-blind readers can tell apart (Okabe and Ito, 2008)."""


def hex_of(colour: Rgb) -> str:
    """Return a colour as HTML, SVG and Matplotlib take it, such as "#0072b2"."""
    return "#{:02x}{:02x}{:02x}".format(*colour)
