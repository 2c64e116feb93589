"""Averaged histograms: from the sums of a window's hops to one value per cell and polarity."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from detector.fly.model_variants import Averaging
from flybench.kernels import compiled

F32 = npt.NDArray[np.float32]

_EVENTS, _BOTH, _AREA, _NONE = range(4)
_DIVISORS = {
    Averaging.EVENTS: _EVENTS,
    Averaging.BOTH: _BOTH,
    Averaging.AREA: _AREA,
    Averaging.NONE: _NONE,
}


def averaged_histogram(
    tallies: npt.NDArray[np.float64], *, averaging: Averaging, cell_area: int, oldest: int = 0
) -> F32:
    """Average the histogram of each cell (paper, equation 5; equations 6 and 7 are its two planes).

    Args:
        tallies: for each hop of a window, the histogram of equation 4 and the number of events in
            it: (hops, 2, rows, columns, 2), dimensionless.
        averaging: what the histogram is divided by.
        cell_area: number of pixels in a cell.
        oldest: index of the first hop of the window; the others follow it cyclically.

    Returns:
        (2, rows, columns) float32; 0 in a cell without events.
    """
    mean: F32 = _averaged(tallies, oldest, _DIVISORS[averaging], float(cell_area))
    return mean


@compiled
def _averaged(tallies: Any, oldest: int, divisor: int, cell_area: float) -> Any:
    hops, _, rows, columns, _ = tallies.shape
    mean = np.zeros((2, rows, columns), np.float32)
    pairs = tallies.reshape(hops, 2, rows, 2 * columns)
    totals = np.zeros((2, 2 * columns))
    for row in range(rows):
        totals[:] = 0.0
        for n in range(oldest, oldest + hops):
            for q in range(2):
                total_row, hop_row = totals[q], pairs[n % hops, q, row]
                for k in range(2 * columns):
                    total_row[k] += hop_row[k]
        for q in range(2):
            for column in range(columns):
                total, count = totals[q, 2 * column], totals[q, 2 * column + 1]
                by = 1.0
                if divisor == _EVENTS:
                    by = max(count, 1.0)
                elif divisor == _BOTH:
                    by = max(count + totals[1 - q, 2 * column + 1], 1.0)
                elif divisor == _AREA:
                    by = cell_area
                mean[q, row, column] = total / by
    return mean
