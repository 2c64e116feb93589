"""Intervals between the events of a pixel on a static scene: how regular the noise is.

Noise comes at irregular times. Its events are not independent: after an ON event, an OFF event is
near. Leak is periodic: the intervals of one pixel are nearly equal, and those of the array vary
with the leak of its pixels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator.characterisation.bench import Recording, lux_label
from emulator.characterisation.experiments.background import record_static
from emulator.characterisation.recordings import healthy_events
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig

DIM_LUX, BRIGHT_LUX = 0.1, 3000.0
"""Illuminance on the chip at which noise is frequent, and at which leak prevails [lux]."""
_BINS = 60
"""Bins of the histogram, evenly spaced in the logarithm."""
_FEWEST = 20
"""Fewest intervals to evaluate: with fewer, the variation would be uncertain by a quarter."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Intervals:
    """Intervals of healthy pixels.

    Attributes:
        interval_s: (n,) intervals between consecutive events of one pixel [s].
        variation: coefficient of variation over all intervals.
        pixel_variation: coefficient of variation within one pixel, mean over pixels.
    """

    interval_s: Floats
    variation: float
    pixel_variation: float


def measure_intervals(recording: Recording) -> Intervals | None:
    """Measure the intervals of a static recording; None if it has too few."""
    healthy = healthy_events(recording.events, recording.shape)
    interval_s = np.diff(healthy.events["t"]) * 1e-6
    same_pixel = np.diff(healthy.pixel) == 0
    interval_s, pixel = interval_s[same_pixel], healthy.pixel[1:][same_pixel]
    if interval_s.size < _FEWEST:
        return None
    number = np.bincount(pixel)
    mean = np.bincount(pixel, interval_s)[number > 2] / number[number > 2]
    square = np.bincount(pixel, interval_s**2)[number > 2] / number[number > 2]
    spread = np.sqrt(np.maximum(square - mean**2, 0.0)) / np.maximum(mean, 1e-12)
    within = float(spread.mean()) if spread.size else float("nan")
    return Intervals(interval_s, float(interval_s.std() / interval_s.mean()), within)


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on intervals between events."""
    quantities, plots = [], []
    for lux, cause in ((DIM_LUX, "noise and leak"), (BRIGHT_LUX, "leak")):
        found = measure_intervals(record_static(config, chip_lux=lux, seed=seed))
        at = f"at {lux_label(lux)} on the chip"
        quantities += [
            Quantity(
                f"variation over all pixels {at}",
                "",
                None if found is None else found.variation,
                note="1 for a Poisson process; unequal pixels raise it",
            ),
            Quantity(
                f"variation within a pixel {at}",
                "",
                None if found is None else found.pixel_variation,
                note="1 for a Poisson process, 0 for a periodic one",
            ),
        ]
        if found is not None:
            plots.append(_plot(found, f"Intervals at {lux_label(lux)}: {cause}"))
    return Section(
        "Intervals between events",
        "Times between consecutive events of one pixel in the static recordings, without hot "
        "pixels, compared with a Poisson process of the same rate. The variation is the standard "
        "deviation over the mean.",
        quantities,
        plots,
    )


def _plot(found: Intervals, title: str) -> Plot:
    intervals_s = np.maximum(found.interval_s, 1e-6)
    edges = np.geomspace(intervals_s.min() * 0.999, intervals_s.max() * 1.001, _BINS + 1)
    number, _ = np.histogram(intervals_s, edges)
    share = number / number.sum()
    expected = -np.diff(np.exp(-edges / intervals_s.mean()))
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
