"""Name, colour and marker of a method, the same in every figure, table and recording."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from dataclasses import dataclass

from scenarios.pipeline.registry import DETECTORS


@dataclass(frozen=True)
class MethodStyle:
    """Style of one method.

    Attributes:
        label: name for readers.
        colour: colour of its lines, as #rrggbb.
        marker: matplotlib's letter for its points, so that colour is not the only difference.
    """

    label: str
    colour: str
    marker: str


_USER_STYLES = (("#7D7D7D", "X"), ("#A0752A", "P"), ("#8A63B0", "*"))
"""Colours and markers for users' classes, visible on white and on black."""


def method_style(method: str) -> MethodStyle:
    """Return the style of a method; a user's class is labelled with its own name.

    A method behind a filter, such as "stcf+fly", is labelled "stcf + event-driven fly".
    """
    if method in DETECTORS:
        entry = DETECTORS[method]
        return MethodStyle(entry.label, entry.colour, entry.marker)
    colour, marker = _USER_STYLES[zlib.crc32(method.encode()) % len(_USER_STYLES)]
    event_filter, _, detector = method.rpartition("+")
    known = event_filter and detector in DETECTORS
    label = f"{event_filter} + {DETECTORS[detector].label}" if known else method
    return MethodStyle(label, colour, marker)


def in_display_order(methods: Iterable[str]) -> list[str]:
    """Return each method once: ours in the order of the registry, then users' classes."""
    found = dict.fromkeys(methods)
    known = [name for name in DETECTORS if name in found]
    return known + [name for name in found if name not in DETECTORS]
