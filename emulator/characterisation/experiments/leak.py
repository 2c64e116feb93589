"""The leak: its rate against light, and against temperature.

The rate is taken from static recordings by `emulator.characterisation.static_fit`, which tells the
leak's clock from shot noise without knowing causes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    chip_luminance,
    decades,
    light_label,
    of_light,
    record,
    resized,
    static_samples,
    uniform,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.characterisation.static_fit import StaticFit, fit_static
from emulator.config import SensorConfig

SIDE_PX = 24
DURATION_S = 300.0
"""Thirty intervals of the published leak; mismatch leaves the mean of 576 pixels 1 % uncertain."""
WARM_LUX = 30.0
"""On the chip: too dim for light to leak, too bright for shot noise to hide the leak [lux]."""
CELSIUS = np.array([15.0, 25.0, 35.0, 45.0, 55.0, 65.0])
"""From a cool room to a hot housing (assumed)."""

Floats = npt.NDArray[np.float64]


def measure_leak(config: SensorConfig, *, chip_lux: float, seed: int) -> StaticFit:
    """Leak and shot noise of a small array at one light on the chip [lux]."""
    sensor = resized(config, width=SIDE_PX, height=SIDE_PX)
    light = uniform(sensor, chip_luminance(sensor, chip_lux))
    recording = record(sensor, static_samples(light, duration_s=DURATION_S), seed=seed)
    return fit_static(recording.events, width=SIDE_PX, height=SIDE_PX, end_us=recording.duration_us)


def leak_line(chip_lux: Floats, leak_hz: npt.ArrayLike) -> tuple[float | None, float | None]:
    """Leak without light [Hz] and what a lux adds [Hz/lux]; None from fewer than two lights.

    Args:
        chip_lux: (n,) light on the chip [lux].
        leak_hz: (n,) leak, NaN where it is unknown [Hz].
    """
    rate = np.asarray(leak_hz, np.float64)
    known = np.isfinite(rate)
    if np.count_nonzero(known) < 2:
        return None, None
    weight = 1.0 / rate[known]
    slope, start = np.polyfit(chip_lux[known], rate[known], 1, w=weight)
    return float(start), float(slope)


def doubling_k(celsius: Floats, leak_hz: npt.ArrayLike) -> float | None:
    """Rise of temperature that doubles the leak [K]; None where it doesn't grow.

    Args:
        celsius: (n,) temperatures [°C].
        leak_hz: (n,) leak, NaN where it is unknown [Hz].
    """
    rate = np.asarray(leak_hz, np.float64)
    known = np.isfinite(rate)
    if np.count_nonzero(known) < 2:
        return None
    octaves_per_k = float(np.polyfit(celsius[known], np.log2(rate[known]), 1)[0])
    return 1.0 / octaves_per_k if octaves_per_k > 0.0 else None


def measure(config: SensorConfig, *, seed: int) -> Section:
    """The leak of the data sheet."""
    lux = decades(3.0, 1e4, 2)
    fits = [measure_leak(config, chip_lux=float(x), seed=seed) for x in lux]
    rates = of_light([fit.leak_hz for fit in fits])
    dark_hz, slope = leak_line(lux, rates)
    warm = [
        measure_leak(replace(config, temperature_c=c), chip_lux=WARM_LUX, seed=seed).leak_hz
        for c in CELSIUS
    ]
    spread = of_light([fit.relative_mismatch for fit in fits])
    relative = float(np.nanmedian(spread)) if np.isfinite(spread).any() else None
    return Section(
        "Leak",
        f"A scene that does not change, seen by {SIDE_PX}×{SIDE_PX} pixels for {DURATION_S:g} s. A "
        "pixel's leak events come after equally long waits, by which they are told from shot "
        "noise; the rate is that of the pixel with the mean threshold, without shot noise. "
        f"Against light at {config.temperature_c:g} °C, against temperature at "
        f"{light_label(WARM_LUX)} on the chip.",
        [
            Quantity("leak without light", "Hz", dark_hz, sources.LEAK_HZ),
            Quantity(
                "what light on the chip adds",
                "Hz/klux",
                None if slope is None else 1e3 * slope,
                sources.LEAK_HZ_PER_KLUX,
            ),
            Quantity(
                "warming that doubles it",
                "K",
                doubling_k(CELSIUS, of_light(warm)),
                sources.LEAK_DOUBLING_K,
            ),
            Quantity(
                "spread over pixels",
                "%",
                None if relative is None else 100.0 * relative,
                note="the mismatch of the ON threshold over the threshold",
            ),
        ],
        [_light_plot(lux, rates, dark_hz, slope), _temperature_plot(of_light(warm))],
    )


def _light_plot(
    lux: Floats, rates: list[float], dark_hz: float | None, slope: float | None
) -> Plot:
    lines = [series("measured", lux, rates, Style.POINTS, 0)]
    if dark_hz is not None and slope is not None:
        x = np.geomspace(lux[0], lux[-1], 100)
        lines.append(series("line", x, dark_hz + slope * x, Style.LINE, 0))
    return Plot(
        "Leak against light",
        "light on the chip [lux]",
        "leak of a pixel [Hz]",
        lines,
        x_log=True,
    )


def _temperature_plot(rates: list[float]) -> Plot:
    return Plot(
        "Leak against temperature",
        "temperature of the chip [°C]",
        "leak of a pixel [Hz]",
        [series("measured", CELSIUS, rates, Style.LINE, 0)],
        y_log=True,
    )
