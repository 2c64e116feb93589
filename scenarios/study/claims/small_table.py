"""Small tables of numbers, the evidence for a claim."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class SmallTable:
    """A few numbers as text.

    Attributes:
        title: what the numbers are, with their unit.
        corner: what the columns are; heading of the first column.
        columns: headings of the other columns.
        rows: name and cells of each row.
    """

    title: str
    corner: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, tuple[str, ...]], ...]


def tables_by_velocity(
    what: str, values: Mapping[str, Mapping[str, str]]
) -> tuple[SmallTable, ...]:
    """Return a table for each lighting, with a column for each velocity.

    Args:
        what: what the numbers are, with their unit.
        values: numbers by name of the row, and then by sequence, such as "day_1.21". A missing one
            is shown as "–".
    """
    sequences = list(dict.fromkeys(name for row in values.values() for name in row))
    lightings = list(dict.fromkeys(name.partition("_")[0] for name in sequences))
    return tuple(
        _table(
            f"{what}, {lighting}", values, [n for n in sequences if n.startswith(f"{lighting}_")]
        )
        for lighting in lightings
    )


def _table(
    title: str, values: Mapping[str, Mapping[str, str]], sequences: Sequence[str]
) -> SmallTable:
    ordered = sorted(sequences, key=_velocity)
    columns = tuple(name.partition("_")[2] for name in ordered)
    rows = tuple(
        (name, tuple(found.get(sequence, "–") for sequence in ordered))
        for name, found in values.items()
        if any(sequence in found for sequence in ordered)
    )
    return SmallTable(title, "rad/s", columns, rows)


def _velocity(sequence: str) -> float:
    return float(sequence.split("_")[1])
