"""Numbers as a person writes them."""

from __future__ import annotations

import math

THIN_SPACE, MINUS = "\u202f", "−"


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, whose plural ends in s: "1 step", "2,000 steps"."""
    return f"{number:,} {noun}" + ("" if number == 1 else "s")


def plain_number(value: float, digits: int = 3) -> str:
    """Format a number to a few digits, without an exponent: 80 500, 8.05, 0.000805.

    Thousands are separated by thin spaces. Zeros at the end are left out, as are digits that
    `digits` does not cover: 80 512 becomes 80 500.
    """
    if value == 0 or abs(value) < 1e-9 or not math.isfinite(value):
        return "0" if math.isfinite(value) else "–"
    decimals = digits - 1 - math.floor(math.log10(abs(value)))
    rounded = round(value, decimals)
    text = f"{rounded:,.{max(decimals, 0)}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return text.replace(",", THIN_SPACE).replace("-", MINUS)
