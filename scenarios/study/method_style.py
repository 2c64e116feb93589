"""How a method looks in every figure and table of the study: its name, colour and marker."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from dataclasses import dataclass

from scenarios.methods import (
    COARSE_FRAME_FLY,
    CONTRAST,
    FLOORLESS_FRAME_FLY,
    FLY,
    FRAME_FLY,
    PLANE_FIT,
    WIDE,
)


@dataclass(frozen=True)
class MethodStyle:
    """How one method is drawn.

    Attributes:
        label: its name for a reader.
        colour: of its lines, as #rrggbb.
        marker: matplotlib's letter for its points, so that colour is never all that tells.
    """

    label: str
    colour: str
    marker: str


_STYLES = {
    FLY: MethodStyle("event-driven fly", "#D55E00", "o"),
    WIDE: MethodStyle("event-driven fly, wide", "#E69F00", "p"),
    FRAME_FLY: MethodStyle("frame-based fly", "#0072B2", "s"),
    COARSE_FRAME_FLY: MethodStyle("frame-based fly, coarse", "#56B4E9", "D"),
    FLOORLESS_FRAME_FLY: MethodStyle("frame-based fly, no floor", "#6b6b6b", "h"),
    CONTRAST: MethodStyle("contrast maximisation", "#009E73", "^"),
    PLANE_FIT: MethodStyle("plane fit", "#CC79A7", "v"),
}
"""Colours that the colour-blind tell apart: M. Okabe and K. Ito, "Color universal design", 2008."""
_OTHERS = (("#000000", "X"), ("#7a5195", "P"), ("#8c6d31", "*"))
"""Of methods that are not ours."""


def method_style(method: str) -> MethodStyle:
    """How a method looks, the same wherever it is drawn; one of the user's goes by its own name."""
    if method in _STYLES:
        return _STYLES[method]
    return MethodStyle(method, *_OTHERS[zlib.crc32(method.encode()) % len(_OTHERS)])


def in_order(methods: Iterable[str]) -> list[str]:
    """Each method once: the fly first, then its rivals, then the user's."""
    found = dict.fromkeys(methods)
    known = [name for name in _STYLES if name in found]
    return known + [name for name in found if name not in _STYLES]
