"""Pixels that show only noise: events there do not follow those of neighbours.

Frames cannot tell them alone: lamps flicker and reflections move between frames, and a recording
may have no frames. The events themselves can. In independent noise of rate R per pixel and
polarity, the age of the latest event at eight neighbours is exponential, so events with an age
below w are exp(8·w·R) times as many as those with an age from w to 2w. What an edge or a lamp
triggers nearly always has an age below w.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from scenarios.event_statistics.pixel_history import COINCIDENCE_US

BLOCK_PX = 8
"""Side of the blocks that are judged as a whole [px] (assumed)."""
MAX_NOISE_HZ = 17.0
"""Highest noise per pixel and polarity that is told from signal [Hz]: events below w are then twice
as many (assumed)."""
_DEVIATIONS = 2.0
"""Standard deviations above chance up to which a block is quiet (assumed)."""

F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]


def chance_share(rate_hz: F64) -> F64:
    """Return the share of ages below w among those below 2w, in independent noise.

    Args:
        rate_hz: rate of noise per pixel and polarity; above 17 Hz, that of 17 Hz is taken [Hz].
    """
    exponent = 8.0 * COINCIDENCE_US * 1e-6 * np.minimum(rate_hz, MAX_NOISE_HZ)
    share: F64 = 1.0 / (1.0 + np.exp(-exponent))
    return share


def quiet_pixels(counts: I64, after_neighbour: I64, span_us: int) -> npt.NDArray[np.bool_]:
    """Return the pixels of blocks whose events follow those of neighbours no more than by chance.

    Args:
        counts: (2, rows, columns) number of events of each polarity.
        after_neighbour: (2, rows, columns) number of events with an age of their neighbours' latest
            event below w, and from w to 2w.
        span_us: duration of the recording, above 0 [µs].

    Returns:
        (rows, columns) True at quiet pixels.
    """
    _, rows, columns = counts.shape
    pixels = _block_sums(np.ones((1, rows, columns), np.int64))[0]
    rate_hz = _block_sums(counts).max(axis=0) / (pixels * span_us * 1e-6)
    near, later = _block_sums(after_neighbour)
    total, chance = near + later, chance_share(rate_hz)
    limit = total * chance + _DEVIATIONS * np.sqrt(total * chance * (1.0 - chance))
    quiet = near <= limit
    of_row, of_column = np.arange(rows) // BLOCK_PX, np.arange(columns) // BLOCK_PX
    return np.asarray(quiet[np.ix_(of_row, of_column)])


def _block_sums(values: I64) -> I64:
    _, rows, columns = values.shape
    by_row = np.add.reduceat(values, np.arange(0, rows, BLOCK_PX), axis=1)
    return np.asarray(np.add.reduceat(by_row, np.arange(0, columns, BLOCK_PX), axis=2))
