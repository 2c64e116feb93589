"""ROC curves of filters: which share of signal and of noise they keep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from detector.denoise import FILTERS, DoubleWindowFilter
from flybench.events import Events

F64 = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

SIGMAS_PX = (0, 1, 2, 3, 4, 5, 6, 8, 10, 14, 20, 30, 50, 100)
"""Distances σ of the double-window filter, whose curve needs one run for each of them [px]."""
MAX_POINTS = 200
"""Most points of a curve that are kept; the area is that of all points."""


@dataclass(frozen=True, eq=False)
class Roc:
    """ROC curve of a filter.

    Attributes:
        kept_noise: (n,) share of noise that is kept at each threshold, rising from 0 to 1.
        kept_signal: (n,) share of signal that is kept at the same thresholds.
        area: area under the curve: 1 for a perfect filter, 0.5 for one that keeps events at random.
        at_default: shares of signal and of noise that are kept with the filter's own threshold.
    """

    kept_noise: F64
    kept_signal: F64
    area: float
    at_default: tuple[float, float]


def measure_roc(name: str, events: Events, is_signal: Bools, *, width: int, height: int) -> Roc:
    """Measure the curve of a filter on a stream whose events are known to be signal or noise.

    The threshold varies along the curve: the greatest age of a supporter, the least surface or, for
    the double-window filter, the distance σ.

    Args:
        name: name of the filter.
        events: (n,) the stream.
        is_signal: (n,) True for signal; both kinds occur.
        width: sensor columns [px].
        height: sensor rows [px].
    """
    made = FILTERS[name](width=width, height=height)
    scores = made.scores(events)
    at_default = kept_shares(scores >= made.threshold, is_signal)
    if name == "double-window":
        points = [_double_window(events, is_signal, s, width, height) for s in SIGMAS_PX]
        noise, signal = _with_ends(points)
    else:
        noise, signal = _curve(scores, is_signal)
    area = float(np.trapezoid(signal, noise))
    along = np.linspace(0.0, noise[-1] + signal[-1], MAX_POINTS)  # evenly along the curve
    chosen = np.unique(np.searchsorted(noise + signal, along))
    return Roc(noise[chosen], signal[chosen], area, at_default)


def kept_shares(kept: Bools, is_signal: Bools) -> tuple[float, float]:
    """Return the shares of signal and of noise that are kept."""
    return float(kept[is_signal].mean()), float(kept[~is_signal].mean())


def _double_window(
    events: Events, is_signal: Bools, sigma_px: int, width: int, height: int
) -> tuple[float, float]:
    made = DoubleWindowFilter(width=width, height=height, sigma_px=sigma_px)
    return kept_shares(made.scores(events) >= made.threshold, is_signal)


def _with_ends(points: Sequence[tuple[float, float]]) -> tuple[F64, F64]:
    """Return the curve through points (signal, noise), from 0, 0 to 1, 1."""
    ordered = sorted((noise, signal) for signal, noise in [(0.0, 0.0), *points, (1.0, 1.0)])
    noise, signal = np.array(ordered).T
    return noise, signal


def _curve(scores: npt.NDArray[np.float32], is_signal: Bools) -> tuple[F64, F64]:
    """Return the shares of noise and of signal with at least each score; equal scores are one."""
    order = np.argsort(-scores, kind="stable")
    ordered = scores[order]
    last_of_equal = np.append(ordered[1:] != ordered[:-1], True)
    signal = np.cumsum(is_signal[order])[last_of_equal]
    noise = np.cumsum(~is_signal[order])[last_of_equal]
    return np.append(0.0, noise / noise[-1]), np.append(0.0, signal / signal[-1])
