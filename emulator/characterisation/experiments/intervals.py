"""Intervals between a pixel's events on a static scene: how regular noise is.

Shot noise is a Poisson process, whose intervals have a coefficient of variation of 1. Leak is a
clock: a pixel's intervals are all alike, and what the array shows of them is the mismatch of its
thresholds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator.characterisation.bench import Recording, counts, light_label
from emulator.characterisation.experiments.background import hot_pixels, record_static
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig

DIM_LUX, BRIGHT_LUX = 0.1, 3000.0
"""On the chip: where shot noise rules, and where leak does [lux]."""
_BINS = 60
"""Of the histogram, even in the logarithm."""
_FEWEST = 20
"""Intervals below which nothing is said of them: a variation would be uncertain by a quarter."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Intervals:
    """Intervals of healthy pixels.

    Attributes:
        interval_s: (n,) intervals between consecutive events of the same pixel [s].
        variation: coefficient of variation over all of them.
        pixel_variation: the same within one pixel, mean over pixels.
    """

    interval_s: Floats
    variation: float
    pixel_variation: float


def measure_intervals(recording: Recording) -> Intervals | None:
    """Intervals of a static recording; None where there are next to none."""
    events = recording.events
    healthy = ~hot_pixels(counts(events, recording.shape))
    kept = events[healthy[events["y"], events["x"]]]
    order = np.lexsort((kept["t"], kept["x"], kept["y"]))
    pixel = kept["y"][order].astype(np.int64) * recording.shape[1] + kept["x"][order]
    gap_s = np.diff(kept["t"][order]) * 1e-6
    same = np.diff(pixel) == 0
    gap_s, pixel = gap_s[same], pixel[1:][same]
    if gap_s.size < _FEWEST:
        return None
    number = np.bincount(pixel)
    mean = np.bincount(pixel, gap_s)[number > 2] / number[number > 2]
    square = np.bincount(pixel, gap_s**2)[number > 2] / number[number > 2]
    spread = np.sqrt(np.maximum(square - mean**2, 0.0)) / np.maximum(mean, 1e-12)
    within = float(spread.mean()) if spread.size else float("nan")
    return Intervals(gap_s, float(gap_s.std() / gap_s.mean()), within)


def measure(config: SensorConfig, *, seed: int) -> Section:
    """The interval histograms of the data sheet."""
    quantities, plots = [], []
    for lux, ruler in ((DIM_LUX, "shot noise"), (BRIGHT_LUX, "leak")):
        found = measure_intervals(record_static(config, chip_lux=lux, seed=seed))
        at = f"at {light_label(lux)} on the chip"
        quantities += [
            Quantity(
                f"variation {at}",
                "",
                None if found is None else found.variation,
                note="1 for a Poisson process",
            ),
            Quantity(
                f"within a pixel {at}",
                "",
                None if found is None else found.pixel_variation,
                note="0 for a clock",
            ),
        ]
        if found is not None:
            plots.append(_plot(found, f"Intervals at {light_label(lux)}: {ruler}"))
    return Section(
        "Intervals between events",
        "The static recordings once more: times between consecutive events of the same pixel, hot "
        "pixels left out, against those of a Poisson process of the same rate. The variation is "
        "the standard deviation over the mean.",
        quantities,
        plots,
    )


def _plot(found: Intervals, title: str) -> Plot:
    gaps = np.maximum(found.interval_s, 1e-6)
    edges = np.geomspace(gaps.min() * 0.999, gaps.max() * 1.001, _BINS + 1)
    number, _ = np.histogram(gaps, edges)
    share = number / number.sum()
    expected = -np.diff(np.exp(-edges / gaps.mean()))
    middle = np.sqrt(edges[1:] * edges[:-1])
    return Plot(
        title,
        "interval [s]",
        "share of intervals in each bin",
        [
            series("measured", middle, share, Style.STEPS, 0),
            series("Poisson process", middle, expected, Style.LINE, 1),
        ],
        x_log=True,
    )
