"""The result of one experiment: measured values, curves and a description of the method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Published:
    """A figure from the literature.

    Attributes:
        value: published value, in the unit of its `Quantity`.
        source: who measured it, on which sensor, and under which conditions.
        another_sensor: True if it belongs to another sensor than the one measured.
    """

    value: float
    source: str
    another_sensor: bool = False


@dataclass(frozen=True)
class Quantity:
    """One row of the data sheet.

    Attributes:
        name: quantity, and the illuminance at which it was measured.
        unit: unit; empty for a pure number.
        measured: measured value; None if the experiment could not measure it.
        published: published figure to compare with; None if we know of none.
        note: remark for the reader, such as why a value is missing.
        counts: False if it is not a figure of this sensor, but of one to compare it with.
    """

    name: str
    unit: str
    measured: float | None
    published: Published | None = None
    note: str = ""
    counts: bool = True

    @property
    def difference(self) -> float | None:
        """Measured over published, minus 1; None if either is missing or published is 0."""
        if self.measured is None or self.published is None or self.published.value == 0.0:
            return None
        return self.measured / self.published.value - 1.0


class Style(StrEnum):
    """Style of a series in a plot."""

    POINTS = "points"
    LINE = "line"
    STEPS = "steps"
    PUBLISHED = "published"
    GUIDE = "guide"


@dataclass(frozen=True, eq=False)
class Series:
    """One curve of a plot.

    Attributes:
        label: name in the legend; empty for none.
        x: (n,) float64 abscissae.
        y: (n,) float64 ordinates; NaN leaves a gap.
        style: how the curve is drawn.
        colour_index: series with the same index share a colour; None: its place in the plot.
    """

    label: str
    x: Values
    y: Values
    style: Style = Style.POINTS
    colour_index: int | None = None


@dataclass(frozen=True, eq=False)
class Plot:
    """Data and labels of one plot."""

    title: str
    x_label: str
    y_label: str
    series: Sequence[Series]
    x_log: bool = False
    y_log: bool = False


@dataclass(frozen=True, eq=False)
class Section:
    """One experiment of the data sheet.

    Attributes:
        title: heading.
        method: stimulus, definition and conditions, in a few sentences.
        quantities: rows of the table.
        plots: plots below the table.
    """

    title: str
    method: str
    quantities: Sequence[Quantity]
    plots: Sequence[Plot] = ()

    @property
    def figures(self) -> dict[str, Quantity]:
        """Rows of the table by name; the first of those with the same name."""
        found: dict[str, Quantity] = {}
        for quantity in self.quantities:
            found.setdefault(quantity.name, quantity)
        return found


def series(
    label: str,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    style: Style = Style.POINTS,
    colour_index: int | None = None,
) -> Series:
    """Make a series from anything that NumPy turns into two arrays of numbers; NaN is a gap."""
    return Series(label, np.asarray(x, np.float64), np.asarray(y, np.float64), style, colour_index)
