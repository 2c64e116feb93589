"""Spearman's rank correlation: does one value rise with another?"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt


def rank_correlation(first: Sequence[float], second: Sequence[float]) -> float:
    """Return Spearman's rank correlation, in [−1, 1]; equal values share the mean of their ranks.

    `scipy.stats.spearmanr` gives the same, but importing it takes a second in every process.

    Args:
        first: two values or more, not all equal.
        second: as many values, not all equal.
    """
    return float(np.corrcoef(_ranks(first), _ranks(second))[0, 1])


def _ranks(values: Sequence[float]) -> npt.NDArray[np.float64]:
    them = np.asarray(values, np.float64)
    lower, equal = them < them[:, np.newaxis], them == them[:, np.newaxis]
    return np.asarray(lower.sum(axis=1) + (equal.sum(axis=1) + 1) / 2, np.float64)
