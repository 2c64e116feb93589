"""The summary at the top of a data sheet: how many figures agree, and the first of each section."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from emulator.characterisation import Datasheet, Quantity

CLOSE, DOUBLE = 0.10, 2.0
"""A figure agrees within 10 %, or within a factor of 2 (assumed, for orientation)."""


@dataclass(frozen=True)
class KeyFigure:
    """One row of the summary: the section that it links to, and its figure."""

    section: str
    title: str
    quantity: Quantity


@dataclass(frozen=True)
class Digest:
    """How the figures agree with those published.

    Attributes:
        compared: number of comparisons with a published figure other than 0.
        close: number of those within 10 %.
        within_double: number of those beyond 10 % and within a factor of 2.
        far: names of the figures of which no comparison is within a factor of 2.
        elsewhere: number of comparisons with figures of another sensor, which are not counted.
        key_figures: the first figure of each section.
    """

    compared: int
    close: int
    within_double: int
    far: list[str]
    elsewhere: int
    key_figures: list[KeyFigure]


def digest(sheet: Datasheet) -> Digest:
    """Return the summary of a data sheet."""
    compared = [q for q in _quantities(sheet) if q.difference is not None and not _other(q)]
    ratios = [(q.name, _ratio(q)) for q in compared]
    near = {name for name, ratio in ratios if ratio <= DOUBLE}
    close = sum(ratio <= 1.0 + CLOSE for _, ratio in ratios)
    return Digest(
        compared=len(ratios),
        close=close,
        within_double=sum(ratio <= DOUBLE for _, ratio in ratios) - close,
        far=list(dict.fromkeys(name for name, _ in ratios if name not in near)),
        elsewhere=sum(q.difference is not None and _other(q) for q in _quantities(sheet)),
        key_figures=[
            KeyFigure(name, section.title, section.quantities[0])
            for name, section in sheet.sections.items()
            if section.quantities
        ],
    )


def _quantities(sheet: Datasheet) -> Iterator[Quantity]:
    for section in sheet.sections.values():
        yield from (quantity for quantity in section.quantities if quantity.counts)


def _other(quantity: Quantity) -> bool:
    return quantity.published is not None and quantity.published.another_sensor


def _ratio(quantity: Quantity) -> float:
    """Return the larger of measured and published over the smaller; infinity if a sign differs."""
    assert quantity.difference is not None
    ratio = quantity.difference + 1.0
    return max(ratio, 1.0 / ratio) if ratio > 0.0 else float("inf")
