"""What the figures of a data sheet mean whose names alone do not tell it."""

from __future__ import annotations

from emulator.characterisation import Quantity

ANOTHER_SOURCE = "the figure of the row above, beside another source"
_MEANINGS = (
    (
        "variation ",
        "standard deviation of the intervals over their mean: 0 if they are equal, 1 for a Poisson "
        "process",
    ),
    (
        "deviation of ln(",
        "standard deviation over the pixels, in ln units: 0.7 means that rates differ by a factor "
        "of 2",
    ),
    (
        "spread of ln(",
        "standard deviation over the pixels, in ln units: 0.7 means that rates differ by a factor "
        "of 2",
    ),
    ("mean of ln(ON/OFF)", "0 means as many ON events as OFF events; 0.7 means twice as many"),
    (
        "Fano factor",
        "variance of the number of events of a pixel over its mean: 1 if all pixels have the same "
        "rate",
    ),
    ("events that alternate", "share that follows an event of the other polarity at its pixel"),
    ("events per line and time stamp", "1 means one event in each line that is read"),
    (
        "moves that go forward",
        "share of the time stamps whose mean line is higher than that of the stamp before",
    ),
    ("jitter over pixels", "standard deviation over all pixels and steps"),
    ("jitter of one pixel", "standard deviation of a pixel from step to step, mean over pixels"),
    ("99th percentile of the delay", "the largest of all loads in the figure"),
    ("full well", "electrons at which a pixel of the frame is saturated"),
)
"""Beginning of a figure's name, and its meaning."""


def note(quantity: Quantity, before: Quantity | None) -> str:
    """Return the remark on a figure: its meaning, its own note, and whether it repeats the last.

    Args:
        quantity: the figure.
        before: the figure of the row above; None for the first row.
    """
    if before is not None and before.name == quantity.name:
        return ANOTHER_SOURCE
    meanings = [text for start, text in _MEANINGS if quantity.name.startswith(start)]
    own = (
        []
        if any("Poisson" in text and "Poisson" in quantity.note for text in meanings)
        else meanings
    )
    return "; ".join(part for part in (*own, quantity.note) if part)
