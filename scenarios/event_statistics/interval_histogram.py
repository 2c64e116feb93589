"""Histogram of time intervals: exact below 128 µs, and at most 1.6 % wide bins above.

Each power of two has 64 bins of equal width, as in an HDR histogram (G. Tene). A histogram of every
interval up to 2⁴² µs (50 days) takes 19 kB, and an interval is counted without a logarithm.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import inlined

_BITS = 6
_EXACT = 2 << _BITS
_LONGEST_BITS = 42
BINS = (_LONGEST_BITS - _BITS + 1) << _BITS
"""Number of bins."""

F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]


@inlined
def interval_bin(interval_us: int) -> int:
    """Return the bin of an interval of 0 µs or more; the last one holds all that are longer."""
    shift = 0
    while interval_us >= _EXACT:
        interval_us >>= 1
        shift += 1
    return min((shift << _BITS) + interval_us, BINS - 1)


def bin_edges_us() -> F64:
    """Return the (BINS + 1,) edges of the bins [µs]."""
    index = np.arange(BINS + 1)
    shift = np.maximum(index >> _BITS, 1) - 1
    edges: F64 = ((index - (shift << _BITS)) << shift).astype(np.float64)
    return edges


def bin_centres_us() -> F64:
    """Return the (BINS,) centres of the bins [µs]: 0.5 for 0 µs, so that each has a logarithm."""
    edges = bin_edges_us()
    centres: F64 = np.maximum((edges[:-1] + edges[1:] - 1.0) / 2.0, 0.5)
    return centres


def quantile_us(histogram: I64, share: float) -> float | None:
    """Return the interval below which a share of all intervals lies [µs]; None if there are none.

    Args:
        histogram: (BINS,) number of intervals in each bin.
        share: 0 to 1.
    """
    total = int(histogram.sum())
    if total == 0:
        return None
    rank = max(1, int(np.ceil(share * total)))
    return float(bin_centres_us()[np.searchsorted(np.cumsum(histogram), rank)])
