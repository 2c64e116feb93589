"""The order and the times that are in the names of images."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

_DECIMAL = re.compile(r"(|.*[_\-\s])(\d{1,30}\.\d{1,30}(?:e-\d\d)?|\d{1,30}e-\d\d)", re.IGNORECASE)
"""A number with decimals, alone or after a separator: 0.01, frame_0.01, 1e-05, not shot1.0001."""
_WHOLE = re.compile(r"(.*?)(\d{1,30})")


def in_order(files: Sequence[Path]) -> list[Path]:
    """Return images in the order of the numbers in their names: 9 before 10, and 0.009 before 0.01.

    Decimals count as values if they end all names, apart from whole numbers among them.
    """
    numbers = numbers_in_names(files)
    if numbers is None:
        return sorted(files, key=_by_number)
    return [file for _, file in sorted(zip(numbers, files, strict=True))]


def numbers_in_names(files: Sequence[Path]) -> list[Fraction] | None:
    """Return the number at the end of each name, or None if it does not tell all images apart."""
    numbers, prefixes = [], set()
    for file in files:
        match = _DECIMAL.fullmatch(file.stem) or _WHOLE.fullmatch(file.stem)
        if match is None:
            return None
        prefixes.add(match[1])
        numbers.append(Fraction(match[2]))
    return numbers if len(prefixes) == 1 and len(set(numbers)) == len(numbers) else None


def _by_number(file: Path) -> list[tuple[int, int | str]]:
    """Return a sort key by which frame_10 comes after frame_9."""
    parts = re.split(r"(\d+)", file.name)
    return [(1, int(part)) if part.isdigit() else (0, part) for part in parts]
