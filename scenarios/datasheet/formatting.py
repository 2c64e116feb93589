"""The numbers of a data sheet as text."""

from __future__ import annotations

import re

from emulator.characterisation import Datasheet, Quantity
from scenarios.output.numbers import MINUS, plain_number

NOT_MEASURED = "–"
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
OTHER_SENSOR_MARK = "*"
"""Mark of figures that were published for another sensor."""


def measured(quantity: Quantity) -> str:
    """Format the measured value with its unit."""
    return with_unit(quantity.measured, quantity.unit)


def published(quantity: Quantity) -> str:
    """Format the published value with its unit, and a mark if it belongs to another sensor.

    Returns:
        The text; empty if nothing is published.
    """
    known = quantity.published
    if known is None:
        return ""
    mark = f" {OTHER_SENSOR_MARK}" if known.another_sensor else ""
    return with_unit(known.value, quantity.unit) + mark


def difference(quantity: Quantity) -> str:
    """Format the difference between the measured and the published value.

    Returns:
        A difference in dB for a quantity in dB; otherwise a percentage, or a factor from 2 on. If
        0 was published, the measured value in its unit. Empty if either value is missing.
    """
    if quantity.measured is None or quantity.published is None:
        return ""
    share = quantity.difference
    if share is None:
        excess = f"+{three_digits(quantity.measured)} {quantity.unit}".strip()
        return excess if quantity.measured else "0.0"
    if quantity.unit == "dB":
        return f"{_signed(quantity.measured - quantity.published.value)} dB"
    if share >= 1.0:
        return f"× {plain_number(float(f'{share + 1.0:.2g}'))}"
    return f"{_signed(100.0 * share)} %"


def footnote(sheet: Datasheet) -> str:
    """Return the explanation of the mark; empty if no figure of the sheet is marked."""
    quantities = [quantity for part in sheet.sections.values() for quantity in part.quantities]
    if not any(x.published is not None and x.published.another_sensor for x in quantities):
        return ""
    return (
        f"{OTHER_SENSOR_MARK} published for another sensor than the one measured here. The "
        "difference is between two sensors, and does not show the accuracy of the emulator."
    )


def source(quantity: Quantity) -> str:
    """Return the source of the published value; empty if nothing is published."""
    return "" if quantity.published is None else quantity.published.source


def short_source(quantity: Quantity) -> str:
    """Return the author of the published value, without the publication."""
    return re.split("[,;:]", source(quantity))[0]


def with_unit(value: float | None, unit: str) -> str:
    """Format a value to three digits with its unit."""
    if value is None:
        return NOT_MEASURED
    return f"{three_digits(value)} {unit}".strip()


def three_digits(value: float) -> str:
    """Format a value to three digits; one that is very small or very large gets a power of ten."""
    if value == 0.0 or 1e-4 <= abs(value) < 1e6:
        return plain_number(value)
    mantissa, _, exponent = f"{value:.2e}".replace("-", "−").partition("e")
    mantissa = plain_number(float(mantissa.replace(MINUS, "-")))
    return f"{mantissa} × 10{str(int(exponent.replace('−', '-'))).translate(_SUPERSCRIPTS)}"


def _signed(value: float) -> str:
    """Format a value to one decimal, with a sign unless it is zero."""
    text = f"{value:+.1f}".replace("-", "−")
    return "0.0" if text in {"+0.0", "−0.0"} else text
