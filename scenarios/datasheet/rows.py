"""The numbers of a data sheet as people read them."""

from __future__ import annotations

import re

from emulator.characterisation import Datasheet, Quantity

NOT_MEASURED = "–"
ANOTHER = "*"
"""Marks what was published for another sensor."""


def measured(quantity: Quantity) -> str:
    """Measured value with its unit."""
    return with_unit(quantity.measured, quantity.unit)


def published(quantity: Quantity) -> str:
    """Published value with its unit, marked if it is another sensor's; empty without one."""
    known = quantity.published
    if known is None:
        return ""
    mark = f" {ANOTHER}" if known.another_sensor else ""
    return with_unit(known.value, quantity.unit) + mark


def difference(quantity: Quantity) -> str:
    """Measured less published: in dB for dB, else as a share, and as a factor where it is large.

    Where 0 was published there is no share, and the difference stands in the unit.
    """
    if quantity.measured is None or quantity.published is None:
        return ""
    share = quantity.difference
    if share is None:
        excess = f"+{quantity.measured:.0e} {quantity.unit}".replace("-", "−").strip()
        return excess if quantity.measured else "0.0"
    if quantity.unit == "dB":
        return f"{_signed(quantity.measured - quantity.published.value)} dB"
    if share >= 1.0:
        return f"× {share + 1.0:.2g}"
    return f"{_signed(100.0 * share)} %"


def footnote(sheet: Datasheet) -> str:
    """What the mark means, where the sheet has it; otherwise nothing."""
    quantities = [quantity for part in sheet.sections.values() for quantity in part.quantities]
    if not any(x.published is not None and x.published.another_sensor for x in quantities):
        return ""
    return (
        f"{ANOTHER} published for another sensor than the one measured here: the difference is "
        "that of two sensors, and tells nothing of how true the emulator is."
    )


def source(quantity: Quantity) -> str:
    """Where the published value comes from."""
    return "" if quantity.published is None else quantity.published.source


def short_source(quantity: Quantity) -> str:
    """Who published it, without where."""
    return re.split("[,;:]", source(quantity))[0]


def with_unit(value: float | None, unit: str) -> str:
    """Three digits and the unit."""
    if value is None:
        return NOT_MEASURED
    return f"{three_digits(value)} {unit}".strip()


def three_digits(value: float) -> str:
    """Three digits, without an exponent where that can be read."""
    if value == 0.0:
        return "0"
    if not 1e-3 <= abs(value) < 1e6:
        text = f"{value:.2e}"
    elif abs(value) >= 1000:
        text = f"{value:,.0f}".replace(",", "\u202f")
    else:
        text = f"{value:.3g}"
    return text.replace("-", "−")


def _signed(value: float) -> str:
    """One decimal, with a sign unless it is zero."""
    text = f"{value:+.1f}".replace("-", "−")
    return "0.0" if text in {"+0.0", "−0.0"} else text
