"""Background activity: the events of a static scene, by polarity and by cause.

The rates are means over all pixels. A few pixels with a high leak contribute much to them;
`emulator.characterisation.experiments.noise_spread` gives the distribution over the pixels.

It is not known whether the illuminances that Joubert 2021 published are those on the chip or on the
scene. The emulator takes them as those on the chip. The noise of the two published cameras agrees
better with the other reading. But bandwidth and leak per lux on the chip would then be 17 times as
high, and the photodiode would have to give 1.5 pA/lux: 20 to 50 times what its area can (assumed:
75 µm²). The last rows are for the sensor of that reading.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
_HIGHEST = {"bandwidth_hz_per_lux": 1e15, "leak_hz_per_lux": 1.0}
"""Highest values that `SensorConfig` accepts of the parameters that are given per lux."""
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


_ByLux = dict[float, Background]
"""Background activity by illuminance on the chip [lux]."""


def record_static(config: SensorConfig, *, chip_lux: float, seed: int) -> Recording:
    """Record a static scene with a small array, for 40 s in dim light or 400 s in bright light."""
    sensor = bench_sensor(config, width=SIDE_PX, height=SIDE_PX)
    luminance = uniform_frame(sensor, chip_luminance(sensor, chip_lux))
    duration_s = _DIM_S if chip_lux < _DIM_LUX else _BRIGHT_S
    return record(sensor, static_samples(luminance, duration_s=duration_s), seed=seed)


def scene_reading(config: SensorConfig) -> SensorConfig:
    """Return the sensor that follows if the published illuminances are those on the scene."""
    return replace(
        config,
        **{
            name: min(getattr(config, name) / CHIP_PER_SCENE, highest)
            for name, highest in _HIGHEST.items()
        },
    )


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
    lux = np.unique(np.concatenate((log_spaced(0.01, 1e4, 2), list(sources.BACKGROUND_HZ))))
    found = _measure_at(lux, config, seed=seed)
    scene_lux = CHIP_PER_SCENE * np.array(sources.JOUBERT_LUX)
    other_lux = np.unique(np.concatenate((scene_lux, sources.CRADLE_LUX)))
    other = _measure_at(other_lux, scene_reading(config), seed=seed)
    return Section(
        "Background activity",
        f"{SIDE_PX}×{SIDE_PX} pixels see a static scene for {_DIM_S:g} s in dim light and "
        f"{_BRIGHT_S:g} s in bright light. Illuminance is given on the chip. Rates are those of "
        "one pixel, mean over all pixels. It is not known whether the illuminances of Joubert 2021 "
        "are those on the chip or on the scene, of which the chip receives 0.06 (assumed). The "
        "emulator takes them as those on the chip: the other reading needs a bandwidth per lux "
        "that is 17 times as high, for which a photodiode of this size gives 20 to 50 times too "
        "little current (estimated). The last rows and the lines “other reading” are for a sensor "
        "with that bandwidth, and with the leak per lux that follows. It is nearer to the DAVIS346 "
        "clip in the dark, and at 0.46 and 2.2 lux, where the sensor of the first rows has far too "
        "many events. But its events of the motion in that clip are farther from the camera's "
        "(docs/explanation/data-sheet.md). Neither sensor has the noise of Joubert 2021 in dim "
        "light, for which the thresholds would have to be about half the default ones.",
        _quantities(found, other),
        [_rate_plot(found, other), _cause_plot(found)],
    )


def _measure_at(lux: npt.NDArray[np.float64], config: SensorConfig, *, seed: int) -> _ByLux:
    """Measure the background activity at each illuminance on the chip [lux], by illuminance."""
    return {
        float(x): measure_background(
            record_static(config, chip_lux=float(x), seed=seed), chip_lux=float(x)
        )
        for x in lux
    }


def _quantities(found: _ByLux, other: _ByLux) -> list[Quantity]:
    quantities = []
    for lux in sources.BACKGROUND_HZ:
        quantities += _rows(found[lux], f"{lux_label(lux)} on the chip", lux)
    hot = 100.0 * found[161.0].hot_share
    name = f"pixels above {_HOT_HZ:g} Hz at 161 lux on the chip"
    quantities.append(Quantity(name, "%", hot, sources.HOT_PERCENT))
    for lux in sources.CRADLE_LUX:
        at = f"{lux_label(lux)} on the chip, other reading"
        quantities += _rows(other[lux], at, lux, counts=False)
    for lux in sources.JOUBERT_LUX:
        at = f"{lux_label(lux)} on the scene, other reading"
        quantities += _rows(other[CHIP_PER_SCENE * lux], at, lux, counts=False)
    return quantities


def _rows(
    background: Background, at: str, published_lux: float, *, counts: bool = True
) -> list[Quantity]:
    """Return the rows of one illuminance, beside the rates published for `published_lux`."""
    on, off = sources.BACKGROUND_HZ[published_lux]
    return [
        Quantity(f"ON events at {at}", "Hz", background.on_hz, on, counts=counts),
        Quantity(f"OFF events at {at}", "Hz", background.off_hz, off, counts=counts),
    ]


def _rate_plot(found: _ByLux, other: _ByLux) -> Plot:
    return Plot(
        "Event rate on a static scene",
        "illuminance on the chip [lux]",
        "rate of a pixel [Hz]",
        [
            *_rate_lines(found, "", 0),
            *_rate_lines(other, ", other reading", 2),
            *_published("Joubert 2021", sources.JOUBERT_LUX),
            *_published("DAVIS346 clip", sources.CRADLE_LUX),
        ],
        x_log=True,
        y_log=True,
    )


def _rate_lines(found: _ByLux, name: str, colour_index: int) -> list[Series]:
    """Return the lines of ON and OFF events."""
    rates = [[b.on_hz for b in found.values()], [b.off_hz for b in found.values()]]
    return [
        series(polarity + name, list(found), _nan_for_zero(rates[k]), Style.LINE, colour_index + k)
        for k, polarity in enumerate(("ON", "OFF"))
    ]


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


def _cause_plot(found: _ByLux) -> Plot:
    lines = [
        series(
            cause.name.lower(),
            list(found),
            _nan_for_zero([b.by_cause_hz[cause] for b in found.values()]),
            Style.LINE,
            colour_index,
        )
        for colour_index, cause in enumerate(Cause)
        if any(b.by_cause_hz[cause] > 0.0 for b in found.values())
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
