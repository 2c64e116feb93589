"""How a method looks in every figure and table of the study: its name, colour and marker."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from dataclasses import dataclass

from scenarios.pipeline.registry import DETECTORS


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


_OTHERS = (("#000000", "X"), ("#7a5195", "P"), ("#8c6d31", "*"))
"""Of methods that are not ours."""


def method_style(method: str) -> MethodStyle:
    """How a method looks, the same wherever it is drawn; one of the user's goes by its own name."""
    if method in DETECTORS:
        entry = DETECTORS[method]
        return MethodStyle(entry.label, entry.colour, entry.marker)
    return MethodStyle(method, *_OTHERS[zlib.crc32(method.encode()) % len(_OTHERS)])


def in_order(methods: Iterable[str]) -> list[str]:
    """Each method once: the fly first, then its rivals, then the user's."""
    found = dict.fromkeys(methods)
    known = [name for name in DETECTORS if name in found]
    return known + [name for name in found if name not in DETECTORS]
