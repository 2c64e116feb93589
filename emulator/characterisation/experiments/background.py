"""Background activity: the events of a static scene, by polarity and by cause.

The rates are means over all pixels. A few pixels with a high leak contribute much to them;
`emulator.characterisation.experiments.noise_spread` gives the distribution over the pixels.

It is not known whether the published illuminances are those on the chip or on the scene. The rows
are for those on the chip. Others give what the sensor does if they are those on the scene.
"""

from __future__ import annotations

from collections.abc import Sequence
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
from emulator.characterisation.section import Plot, Quantity, Section, Series, Style, series
from emulator.config import SensorConfig
from flybench.events import Cause

SIDE_PX = 64
"""Side of the array; more pixels than the 50×50 of the published recording."""
_DIM_LUX, _DIM_S, _BRIGHT_S = 3.0, 40.0, 400.0
"""Illuminance on the chip below which noise is quick to count, and the two durations [lux, s]."""
CHIP_PER_SCENE = 0.06
"""Illuminance on the chip over that on the scene, if the published one is on the scene (assumed:
grey card and ordinary lens, 0.02 to 0.10; with 0.06 the noise of the two cameras peaks alike)."""
_HOT_HZ = 15.0
"""Rate above which a pixel counts as hot: two of 2,500 pixels of Joubert 2021 are above it [Hz]."""


@dataclass(frozen=True)
class Background:
    """Background activity of a pixel at one illuminance, mean over all pixels.

    Attributes:
        chip_lux: illuminance on the chip [lux].
        on_hz: rate of ON events [Hz].
        off_hz: rate of OFF events [Hz].
        by_cause_hz: rate of all events by `Cause` [Hz].
        hot_share: share of pixels above 15 Hz.
    """

    chip_lux: float
    on_hz: float
    off_hz: float
    by_cause_hz: dict[Cause, float]
    hot_share: float


def record_static(config: SensorConfig, *, chip_lux: float, seed: int) -> Recording:
    """Record a static scene with a small array, for 40 s in dim light or 400 s in bright light."""
    sensor = bench_sensor(config, width=SIDE_PX, height=SIDE_PX)
    luminance = uniform_frame(sensor, chip_luminance(sensor, chip_lux))
    duration_s = _DIM_S if chip_lux < _DIM_LUX else _BRIGHT_S
    return record(sensor, static_samples(luminance, duration_s=duration_s), seed=seed)


def measure_background(recording: Recording, *, chip_lux: float) -> Background:
    """Measure the event rates of a static recording."""
    events = recording.events
    time_s = recording.duration_us * 1e-6
    rates = event_counts(events, recording.shape) / time_s
    on_hz = np.count_nonzero(events["p"]) / (time_s * rates.size)
    off_hz = np.count_nonzero(~events["p"]) / (time_s * rates.size)
    causes = np.bincount(recording.causes, minlength=len(Cause)) / (time_s * rates.size)
    by_cause = {cause: float(causes[cause]) for cause in Cause}
    return Background(chip_lux, on_hz, off_hz, by_cause, float((rates > _HOT_HZ).mean()))


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on background activity."""
    on_scene = CHIP_PER_SCENE * np.array(sources.JOUBERT_LUX)
    lux = np.unique(
        np.concatenate((log_spaced(0.01, 1e4, 2), list(sources.BACKGROUND_HZ), on_scene))
    )
    found = [
        measure_background(record_static(config, chip_lux=float(x), seed=seed), chip_lux=float(x))
        for x in lux
    ]
    return Section(
        "Background activity",
        f"{SIDE_PX}×{SIDE_PX} pixels see a static scene for {_DIM_S:g} s in dim light and "
        f"{_BRIGHT_S:g} s in bright light. Illuminance is given on the chip. Rates are those of "
        "one pixel, mean over all pixels. The noise of the two published cameras peaks at "
        "different illuminances if both are those on the chip. It peaks alike if that of Joubert "
        "2021 is on the scene and the chip receives 0.06 of it; the last rows are for that case. "
        "In neither case does the sensor have the noise of Joubert 2021 in dim light, which takes "
        "thresholds of about half the default ones. Compared with the DAVIS346 clip, the sensor "
        "has fewer OFF events in the dark, and far too many events at 0.46 and 2.2 lux.",
        _quantities(found),
        [_rate_plot(found), _cause_plot(found)],
    )


def _quantities(found: list[Background]) -> list[Quantity]:
    by_lux = {background.chip_lux: background for background in found}
    quantities = []
    for lux in sources.BACKGROUND_HZ:
        quantities += _rows(by_lux[lux], f"{lux_label(lux)} on the chip", lux)
    for lux in sources.JOUBERT_LUX:
        chip_lux = CHIP_PER_SCENE * lux
        at = f"{lux_label(lux)} on the scene, {lux_label(chip_lux)} on the chip"
        quantities += _rows(by_lux[chip_lux], at, lux)
    hot = 100.0 * by_lux[161.0].hot_share
    name = f"pixels above {_HOT_HZ:g} Hz at 161 lux on the chip"
    return [*quantities, Quantity(name, "%", hot, sources.HOT_PERCENT)]


def _rows(background: Background, at: str, published_lux: float) -> list[Quantity]:
    """Return the rows of one illuminance, beside the rates published for `published_lux`."""
    on, off = sources.BACKGROUND_HZ[published_lux]
    return [
        Quantity(f"ON events at {at}", "Hz", background.on_hz, on),
        Quantity(f"OFF events at {at}", "Hz", background.off_hz, off),
    ]


def _rate_plot(found: list[Background]) -> Plot:
    lux = [b.chip_lux for b in found]
    return Plot(
        "Event rate on a static scene",
        "illuminance on the chip [lux]",
        "rate of a pixel [Hz]",
        [
            series("ON", lux, _nan_for_zero([b.on_hz for b in found]), Style.LINE, 0),
            series("OFF", lux, _nan_for_zero([b.off_hz for b in found]), Style.LINE, 1),
            *_published("Joubert 2021", sources.JOUBERT_LUX),
            *_published("DAVIS346 clip", sources.CRADLE_LUX),
        ],
        x_log=True,
        y_log=True,
    )


def _published(name: str, lux: Sequence[float]) -> list[Series]:
    """Return the published rates of one camera, ON and OFF."""
    return [
        series(
            f"{name}, {polarity}",
            lux,
            _nan_for_zero([sources.BACKGROUND_HZ[x][i].value for x in lux]),
            Style.PUBLISHED,
            i,
        )
        for i, polarity in enumerate(("ON", "OFF"))
    ]


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
        "Event rate by cause",
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
