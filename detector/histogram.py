"""From sums of time surfaces to averages: what a cell says about a window."""

from __future__ import annotations

from enum import StrEnum
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit


class Averaging(StrEnum):
    """What the sum over a cell's events is divided by (equation 5)."""

    EVENTS = "events"
    """The number of the cell's events in the window: the paper's |C|."""
    AREA = "area"
    """The number of pixels in a cell: few events then count for little."""
    NONE = "none"
    """Nothing: the histogram of equation 4."""


def averaged_histogram(
    sums: npt.NDArray[np.float64],
    counts: npt.NDArray[np.int64],
    *,
    averaging: Averaging,
    cell_area: int,
) -> npt.NDArray[np.float32]:
    """Average the histogram of each cell (paper, equation 5; 6 and 7 are its two planes).

    Args:
        sums: histogram of equation 4, (2, rows, columns), dimensionless.
        counts: events behind each sum, same shape.
        averaging: what to divide by.
        cell_area: pixels in a cell.

    Returns:
        (2, rows, columns) float32; 0 where a cell has no event.
    """
    if averaging is Averaging.EVENTS:
        sums = sums / np.maximum(counts, 1)
    elif averaging is Averaging.AREA:
        sums = sums / cell_area
    return sums.astype(np.float32)


@njit(cache=True)
def window_sums(sums: Any, counts: Any, hops: Any) -> Any:
    """Add up the chosen hops in the order given.

    Args:
        sums: (hops kept, 2, rows, columns) float64.
        counts: same shape, int64.
        hops: indices on the first axis.

    Returns:
        Sum and number of events, each (2, rows, columns).
    """
    total, number = np.zeros_like(sums[0]), np.zeros_like(counts[0])
    for hop in hops:
        total += sums[hop]
        number += counts[hop]
    return total, number
