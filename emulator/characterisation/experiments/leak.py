"""The leak: its rate against illuminance, and against temperature.

`emulator.characterisation.static_fit` estimates the leak of the median pixel and its spread from
static recordings in which OFF events are so rare that noise hardly adds to the leak.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    bench_sensor,
    chip_luminance,
    log_spaced,
    lux_label,
    nan_for_none,
    record,
    static_samples,
    uniform_frame,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.characterisation.static_fit import StaticFit, fit_static
from emulator.config import SensorConfig

SIDE_PX = 24
DURATION_S = 300.0
"""Fifteen periods of the published leak [s]. Its spread makes the median of 576 pixels uncertain by
2 %, equally at all illuminances and temperatures."""
WARM_LUX = 200.0
"""Illuminance on the chip for the temperatures: bright enough for hardly any noise. What
the light adds to the leak is subtracted [lux]."""
CELSIUS = np.array([15.0, 25.0, 35.0, 45.0, 55.0, 65.0])
"""Temperatures from a cool room to a hot housing (assumed) [°C]."""

SPREAD_LUX = (161.0, 3000.0)
"""Illuminances on the chip at which a spread over pixels is published [lux]."""

Floats = npt.NDArray[np.float64]
Line = tuple[float | None, float | None]
"""Leak in the dark [Hz] and what each lux adds [Hz/lux]; None if unknown."""


def measure_leak(config: SensorConfig, *, chip_lux: float, seed: int) -> StaticFit:
    """Measure the leak of a small array at one illuminance on the chip [lux]."""
    sensor = bench_sensor(config, width=SIDE_PX, height=SIDE_PX)
    luminance = uniform_frame(sensor, chip_luminance(sensor, chip_lux))
    recording = record(sensor, static_samples(luminance, duration_s=DURATION_S), seed=seed)
    return fit_static(recording.events, width=SIDE_PX, height=SIDE_PX, end_us=recording.duration_us)


def leak_line(chip_lux: Floats, leak_hz: npt.ArrayLike) -> Line:
    """Fit a line to the leak: in the dark [Hz], and added by each lux [Hz/lux].

    Args:
        chip_lux: (n,) illuminance on the chip [lux].
        leak_hz: (n,) leak, NaN where it is unknown [Hz].

    Returns:
        Intercept and slope; both None if fewer than two leaks are known.
    """
    rate = np.asarray(leak_hz, np.float64)
    known = np.isfinite(rate)
    if np.count_nonzero(known) < 2:
        return None, None
    weight = 1.0 / rate[known]
    slope, start = np.polyfit(chip_lux[known], rate[known], 1, w=weight)
    return float(start), float(slope)


def doubling_k(celsius: Floats, leak_hz: npt.ArrayLike) -> float | None:
    """Return the rise of temperature that doubles the leak [K]; None if it does not grow.

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
    """Return the section on the leak."""
    lux = np.unique(np.concatenate((log_spaced(100.0, 1e4, 2), SPREAD_LUX)))
    fits = [measure_leak(config, chip_lux=float(x), seed=seed) for x in lux]
    rates = nan_for_none([fit.leak_hz for fit in fits])
    line = leak_line(lux, rates)
    by_celsius = [
        measure_leak(replace(config, temperature_c=c), chip_lux=WARM_LUX, seed=seed).leak_hz
        for c in CELSIUS
    ]
    warm = nan_for_none(by_celsius)
    warm_without_light = [rate - WARM_LUX * (line[1] or 0.0) for rate in warm]
    return Section(
        "Leak",
        f"{SIDE_PX}×{SIDE_PX} pixels see a static scene for {DURATION_S:g} s, in light in which "
        "OFF events are so rare that ON events are leak. The rate is that of the median pixel. The "
        "spread is the standard deviation of ln(leak), from the median and the quantile one "
        "deviation below it, so that the tail of noisy pixels hardly counts. Illuminance varies at "
        f"{config.temperature_c:g} °C, temperature at {lux_label(WARM_LUX)} on the chip.",
        _quantities(line, warm_without_light, dict(zip(lux.tolist(), fits, strict=True))),
        [_lux_plot(lux, rates, line), _temperature_plot(warm)],
    )


def _quantities(line: Line, warm: list[float], fits: dict[float, StaticFit]) -> list[Quantity]:
    dark_hz, slope = line
    per_klux = None if slope is None else 1e3 * slope
    doubling = doubling_k(CELSIUS, warm)
    return [
        Quantity("leak without light", "Hz", dark_hz, sources.LEAK_HZ),
        Quantity("leak without light", "Hz", dark_hz, sources.LEAK_HZ_NOZAKI),
        Quantity("leak added by light on the chip", "Hz/klux", per_klux, sources.LEAK_HZ_PER_KLUX),
        Quantity("warming that doubles the leak", "K", doubling, sources.LEAK_DOUBLING_K),
        *(
            Quantity(
                f"spread of ln(leak) over pixels at {lux_label(lux)}",
                "",
                fits[lux].leak_spread,
                published,
                "the mismatch of the ON threshold is in it",
            )
            for lux, published in zip(SPREAD_LUX, sources.LEAK_SPREAD, strict=True)
        ),
    ]


def _lux_plot(lux: Floats, rates: list[float], line: Line) -> Plot:
    dark_hz, slope = line
    lines = [series("measured", lux, rates, Style.POINTS, 0)]
    if dark_hz is not None and slope is not None:
        x = np.geomspace(lux[0], lux[-1], 100)
        lines.append(series("fitted line", x, dark_hz + slope * x, Style.LINE, 0))
    return Plot(
        "Leak against illuminance",
        "illuminance on the chip [lux]",
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
