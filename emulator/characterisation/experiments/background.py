"""Background activity: what a sensor says of a scene that does not change, and why.

Hot pixels are found as on a real sensor, by their rate, and left out of the rates of the healthy
ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    Counts,
    Recording,
    chip_luminance,
    counts,
    decades,
    light_label,
    record,
    resized,
    static_samples,
    uniform,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from flybench.events import Cause

SIDE_PX = 64
"""More pixels than the 50×50 of the published recording."""
_DIM_LUX, _DIM_S, _BRIGHT_S = 3.0, 20.0, 400.0
"""Light on the chip below which shot noise is quick to count, and how long to count: at the
published rates a thousand events or more of each polarity at 0.1 and 161 lux."""
_HOT_DEVIATIONS = 8.0
"""Of chance, beyond which a pixel is hot: one healthy pixel in 10¹⁵."""


@dataclass(frozen=True)
class Background:
    """Background activity of a healthy pixel at one light.

    Attributes:
        chip_lux: light on the chip [lux].
        on_hz: ON events [Hz].
        off_hz: OFF events [Hz].
        by_cause_hz: all events, by `Cause` [Hz]; these count hot pixels too.
        hot_share: share of pixels that were left out as hot.
    """

    chip_lux: float
    on_hz: float
    off_hz: float
    by_cause_hz: dict[Cause, float]
    hot_share: float


def hot_pixels(number: Counts) -> npt.NDArray[np.bool_]:
    """Which pixels fire far more often than the others.

    Args:
        number: (height, width) events of each pixel.

    Returns:
        (height, width), true where a count lies eight deviations above the median; the deviation
        is the larger of chance's and the one that the array's quartiles show.
    """
    low, median, high = np.percentile(number, [25, 50, 75])
    deviation = max(np.sqrt(median + 1.0), (high - low) / 1.35)
    return np.asarray(number > median + _HOT_DEVIATIONS * deviation, np.bool_)


def record_static(config: SensorConfig, *, chip_lux: float, seed: int) -> Recording:
    """A minute or more of one light, on a small square of pixels."""
    sensor = resized(config, width=SIDE_PX, height=SIDE_PX)
    light = uniform(sensor, chip_luminance(sensor, chip_lux))
    duration_s = _DIM_S if chip_lux < _DIM_LUX else _BRIGHT_S
    return record(sensor, static_samples(light, duration_s=duration_s), seed=seed)


def measure_background(recording: Recording, *, chip_lux: float) -> Background:
    """Rates of a static recording."""
    events = recording.events
    healthy = ~hot_pixels(counts(events, recording.shape))
    time_s = recording.duration_us * 1e-6
    on = counts(events[events["p"]], recording.shape)[healthy].mean() / time_s
    off = counts(events[~events["p"]], recording.shape)[healthy].mean() / time_s
    causes = np.bincount(recording.causes, minlength=len(Cause)) / (time_s * healthy.size)
    by_cause = {cause: float(causes[cause]) for cause in Cause}
    return Background(chip_lux, float(on), float(off), by_cause, 1.0 - float(healthy.mean()))


def measure(config: SensorConfig, *, seed: int) -> Section:
    """The background activity of the data sheet."""
    lux = np.unique(np.concatenate((decades(0.01, 1e4, 2), list(sources.BACKGROUND_HZ))))
    found = [
        measure_background(record_static(config, chip_lux=float(x), seed=seed), chip_lux=float(x))
        for x in lux
    ]
    return Section(
        "Background activity",
        f"A scene that does not change, seen by {SIDE_PX}×{SIDE_PX} pixels for {_DIM_S:g} s in dim "
        f"light and {_BRIGHT_S:g} s in bright; light is given on the chip, "
        "rates are those of one pixel. Pixels that fire far "
        "more often than the others are taken for hot and left out, but counted in the split by "
        "cause.",
        _quantities(found),
        [_rate_plot(found), _cause_plot(found)],
    )


def _quantities(found: list[Background]) -> list[Quantity]:
    quantities = []
    for background in found:
        published = sources.BACKGROUND_HZ.get(background.chip_lux)
        if published is None:
            continue
        on, off = published
        at = f"{light_label(background.chip_lux)} on the chip"
        quantities += [
            Quantity(f"ON at {at}", "Hz", background.on_hz, on),
            Quantity(f"OFF at {at}", "Hz", background.off_hz, off),
        ]
    shares = [background.hot_share for background in found]
    return [*quantities, Quantity("hot pixels", "%", 100.0 * float(np.median(shares)))]


def _rate_plot(found: list[Background]) -> Plot:
    lux = [b.chip_lux for b in found]
    known = np.array(list(sources.BACKGROUND_HZ))
    on, off = (np.array([pair[i].value for pair in sources.BACKGROUND_HZ.values()]) for i in (0, 1))
    return Plot(
        "Events on a scene that does not change",
        "light on the chip [lux]",
        "rate of a pixel [Hz]",
        [
            series("ON", lux, _positive([b.on_hz for b in found]), Style.LINE, 0),
            series("OFF", lux, _positive([b.off_hz for b in found]), Style.LINE, 1),
            series("Joubert 2021, ON", known, on, Style.PUBLISHED, 0),
            series("Joubert 2021, OFF", known, _positive(off), Style.PUBLISHED, 1),
        ],
        x_log=True,
        y_log=True,
    )


def _cause_plot(found: list[Background]) -> Plot:
    lux = [b.chip_lux for b in found]
    lines = [
        series(
            cause.name.lower(),
            lux,
            _positive([b.by_cause_hz[cause] for b in found]),
            Style.LINE,
            tint,
        )
        for tint, cause in enumerate(Cause)
        if any(b.by_cause_hz[cause] > 0.0 for b in found)
    ]
    return Plot(
        "The same by cause, hot pixels included",
        "light on the chip [lux]",
        "rate, mean over all pixels [Hz]",
        lines,
        x_log=True,
        y_log=True,
    )


def _positive(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """What a logarithmic axis can show: NaN for zero."""
    rates = np.asarray(values, np.float64)
    return np.where(rates > 0.0, rates, np.nan)
