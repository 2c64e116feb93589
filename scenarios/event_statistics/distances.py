"""Distances between two values or two distributions of a statistic.

Each is 0 for equal statistics and symmetric. A distance is None if one of the statistics is None,
or where none is defined.
"""

from __future__ import annotations

import math

from scipy.stats import wasserstein_distance

from scenarios.event_statistics.interval_histogram import I64, bin_centres_us
from scenarios.event_statistics.noise import NoiseClass

_MIN_PIXELS = 100
"""Fewest quiet pixels of a class that is compared (assumed)."""
_HALF_EVENT = 0.5
"""Count that is added to both numbers of events, so that a class without events has a logarithm
(Anscombe 1956)."""


def log_ratio(a: float | None, b: float | None) -> float | None:
    """Return |ln(b/a)| of positive numbers: 0.69 for a factor of two, up or down (assumed)."""
    if a is None or b is None or a <= 0 or b <= 0:
        return None
    return abs(math.log(b / a))


def difference(a: float | None, b: float | None) -> float | None:
    """Return |b − a|; of shares, it is the total variation distance of two Bernoulli laws."""
    return None if a is None or b is None else abs(b - a)


def interval_distance(a: I64, b: I64) -> float | None:
    """Return the first Wasserstein distance of the logarithms of two sets of intervals.

    It is the mean |ln| of the factors by which intervals must be changed to turn one distribution
    into the other (Rubner, Tomasi, Guibas, IJCV 40, 2000: the earth mover's distance).

    Args:
        a: (BINS,) histogram of intervals.
        b: (BINS,) the other histogram.
    """
    if not a.any() or not b.any():
        return None
    centres = [math.log(centre) for centre in bin_centres_us()]
    return float(wasserstein_distance(centres, centres, a, b))


def are_comparable(a: NoiseClass, b: NoiseClass) -> bool:
    """Return True if both recordings have enough quiet pixels in this class of brightness."""
    return min(a.pixels, b.pixels) >= _MIN_PIXELS


def noise_distance(a: NoiseClass, b: NoiseClass) -> float | None:
    """Return |ln| of the ratio of the rates of noise, with half an event added to each count."""
    if not are_comparable(a, b):
        return None
    rates = [(c.on + c.off + _HALF_EVENT) / (c.pixels * c.seconds) for c in (a, b)]
    return log_ratio(*rates)
