"""Background activity: the events of a static scene, by polarity and by cause.

Hot pixels are found by their rate, as on a real sensor, and left out of the rates of the healthy
pixels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    Recording,
    bench_sensor,
    chip_luminance,
    event_counts,
    log_spaced,
    lux_label,
    record,
    static_samples,
    uniform_frame,
)
from emulator.characterisation.recordings import hot_pixels
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from flybench.events import Cause

SIDE_PX = 64
"""Side of the array; more pixels than the 50×50 of the published recording."""
_DIM_LUX, _DIM_S, _BRIGHT_S = 3.0, 20.0, 400.0
"""Illuminance on the chip below which shot noise is quick to count, and the two durations. At the
published rates they give a thousand events or more of each polarity at 0.1 and 161 lux."""


@dataclass(frozen=True)
class Background:
    """Background activity of a healthy pixel at one illuminance.

    Attributes:
        chip_lux: illuminance on the chip [lux].
        on_hz: rate of ON events [Hz].
        off_hz: rate of OFF events [Hz].
        by_cause_hz: rate of all events by `Cause`, including hot pixels [Hz].
        hot_share: share of pixels that were left out as hot.
    """

    chip_lux: float
    on_hz: float
    off_hz: float
    by_cause_hz: dict[Cause, float]
    hot_share: float


def record_static(config: SensorConfig, *, chip_lux: float, seed: int) -> Recording:
    """Record a static scene with a small array, for 20 s in dim light or 400 s in bright light."""
    sensor = bench_sensor(config, width=SIDE_PX, height=SIDE_PX)
    luminance = uniform_frame(sensor, chip_luminance(sensor, chip_lux))
    duration_s = _DIM_S if chip_lux < _DIM_LUX else _BRIGHT_S
    return record(sensor, static_samples(luminance, duration_s=duration_s), seed=seed)


def measure_background(recording: Recording, *, chip_lux: float) -> Background:
    """Measure the event rates of a static recording."""
    events = recording.events
    healthy = ~hot_pixels(event_counts(events, recording.shape))
    time_s = recording.duration_us * 1e-6
    on = event_counts(events[events["p"]], recording.shape)[healthy].mean() / time_s
    off = event_counts(events[~events["p"]], recording.shape)[healthy].mean() / time_s
    causes = np.bincount(recording.causes, minlength=len(Cause)) / (time_s * healthy.size)
    by_cause = {cause: float(causes[cause]) for cause in Cause}
    return Background(chip_lux, float(on), float(off), by_cause, 1.0 - float(healthy.mean()))


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on background activity."""
    lux = np.unique(np.concatenate((log_spaced(0.01, 1e4, 2), list(sources.BACKGROUND_HZ))))
    found = [
        measure_background(record_static(config, chip_lux=float(x), seed=seed), chip_lux=float(x))
        for x in lux
    ]
    return Section(
        "Background activity",
        f"{SIDE_PX}×{SIDE_PX} pixels see a static scene for {_DIM_S:g} s in dim light and "
        f"{_BRIGHT_S:g} s in bright light. Illuminance is given on the chip. Rates are those of "
        "one pixel. Pixels that fire far more often than the others count as hot. They are left "
        "out of the rates, but included in the split by cause.",
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
        at = f"{lux_label(background.chip_lux)} on the chip"
        quantities += [
            Quantity(f"ON events at {at}", "Hz", background.on_hz, on),
            Quantity(f"OFF events at {at}", "Hz", background.off_hz, off),
        ]
    shares = [background.hot_share for background in found]
    return [*quantities, Quantity("hot pixels", "%", 100.0 * float(np.median(shares)))]


def _rate_plot(found: list[Background]) -> Plot:
    lux = [b.chip_lux for b in found]
    known = np.array(list(sources.BACKGROUND_HZ))
    on, off = (np.array([pair[i].value for pair in sources.BACKGROUND_HZ.values()]) for i in (0, 1))
    return Plot(
        "Event rate on a static scene",
        "illuminance on the chip [lux]",
        "rate of a pixel [Hz]",
        [
            series("ON", lux, _nan_for_zero([b.on_hz for b in found]), Style.LINE, 0),
            series("OFF", lux, _nan_for_zero([b.off_hz for b in found]), Style.LINE, 1),
            series("Joubert 2021, ON", known, on, Style.PUBLISHED, 0),
            series("Joubert 2021, OFF", known, _nan_for_zero(off), Style.PUBLISHED, 1),
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
            _nan_for_zero([b.by_cause_hz[cause] for b in found]),
            Style.LINE,
            colour_index,
        )
        for colour_index, cause in enumerate(Cause)
        if any(b.by_cause_hz[cause] > 0.0 for b in found)
    ]
    return Plot(
        "Event rate by cause, including hot pixels",
        "illuminance on the chip [lux]",
        "rate, mean over all pixels [Hz]",
        lines,
        x_log=True,
        y_log=True,
    )


def _nan_for_zero(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return the values with NaN for zero, which a logarithmic axis cannot show."""
    rates = np.asarray(values, np.float64)
    return np.where(rates > 0.0, rates, np.nan)
