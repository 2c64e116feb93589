"""What an experiment hands over: figures, curves, and how they were measured."""

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
        value: in the unit of the quantity that it stands beside.
        source: who measured it, on what, under which conditions.
        another_sensor: whether it is of another sensor than the one that was measured.
    """

    value: float
    source: str
    another_sensor: bool = False


@dataclass(frozen=True)
class Quantity:
    """One line of the data sheet.

    Attributes:
        name: what was measured, and under which light.
        unit: its unit, empty for a pure number.
        measured: what the experiment gave; None where it could not be measured.
        published: the figure to compare with, None where we know none.
        note: why it could not be measured, or what to know when reading it.
    """

    name: str
    unit: str
    measured: float | None
    published: Published | None = None
    note: str = ""

    @property
    def difference(self) -> float | None:
        """Measured over published, less one; None where either is missing or published is 0."""
        if self.measured is None or self.published is None or self.published.value == 0.0:
            return None
        return self.measured / self.published.value - 1.0


class Style(StrEnum):
    """How a series is drawn."""

    POINTS = "points"
    LINE = "line"
    STEPS = "steps"
    PUBLISHED = "published"
    GUIDE = "guide"


@dataclass(frozen=True, eq=False)
class Series:
    """One curve: x and y are (n,) float64; NaN leaves a gap. Series of a `tint` share a colour."""

    label: str
    x: Values
    y: Values
    style: Style = Style.POINTS
    tint: int | None = None


@dataclass(frozen=True, eq=False)
class Plot:
    """One figure, still undrawn."""

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
        title: its heading.
        method: stimulus, definition and conditions, in a few sentences.
        quantities: its lines in the table.
        plots: its figures.
    """

    title: str
    method: str
    quantities: Sequence[Quantity]
    plots: Sequence[Plot] = ()

    @property
    def figures(self) -> dict[str, Quantity]:
        """The lines of the table by name; of those named "the same" the last."""
        return {quantity.name: quantity for quantity in self.quantities}


def series(
    label: str,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    style: Style = Style.POINTS,
    tint: int | None = None,
) -> Series:
    """Series from anything that becomes two arrays of numbers; NaN is a gap."""
    return Series(label, np.asarray(x, np.float64), np.asarray(y, np.float64), style, tint)
