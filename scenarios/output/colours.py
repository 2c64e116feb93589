"""Colours of polarity and of plain curves, the same in every figure, page, film and viewer.

`scenarios.pipeline.registry` has the colours of the methods.
"""

from __future__ import annotations

from typing import Final

Rgb = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""

ON: Final[Rgb] = (0, 114, 178)
OFF: Final[Rgb] = (213, 94, 0)
"""Blue and vermilion for ON and OFF events, from the palette of Okabe and Ito (2008).

Their contrast is 5.2 and 3.9 to 1 on white, and 4.1 and 5.4 to 1 on black, where WCAG 2.2 asks for
3 to 1. On grey levels in between, they differ from the background by hue alone.
"""
SERIES: Final = ("#2B3440", "#009E73", "#CC79A7", "#E69F00", "#6B6B6B")
"""Curves that are neither a polarity nor a method, in turn (Okabe and Ito, 2008; two greys). They
also need different markers or lines."""


def hex_of(rgb: Rgb) -> str:
    """Return a colour as HTML, SVG and Matplotlib take it, such as "#0072b2"."""
    return "#{:02x}{:02x}{:02x}".format(*rgb)


def rgb_of(colour: str) -> Rgb:
    """Return a colour in the form #rrggbb as red, green and blue."""
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return red, green, blue
