"""A lamp on the mains that fills a group of pixels: rates of ON and OFF events at 100 Hz.

The logarithm of the light is assumed to rise and fall in straight lines, either equally fast or
with a sudden fall. Neither the luminance nor the course of the recorded lamp is known, because its
pixels are saturated in the frames. But its ON events come about 1 ms apart all through the cycle,
and its OFF events all within 0.6 ms. If the light rises and falls equally fast, θ_on·R_on −
θ_off·R_off is the drift of the leak, which is far too small for the recorded rates. A sudden fall
hides in the refractory period after one or two OFF events.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    bench_sensor,
    chip_luminance,
    event_counts,
    record,
    uniform_frame,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from flybench.events import Events

SIZE = 16
"""Rows and columns of the array [px]."""
FLICKER_HZ = 100.0
"""Frequency of lamps on mains of 50 Hz [Hz]."""
CHIP_LUX = 20_000.0
"""Illuminance on the chip (assumed: a diffuse lamp of 56,000 cd/m² through f/1.4) [lux]."""
SWINGS = (0.25, 0.5, 1.0, 1.5, 2.0, 2.65, 3.3)
SWING = 2.65
"""Swing of the light for the table [ln units]: the 7.45 recorded ON events of a cycle times a
threshold of 0.28, and the rise in their refractory periods of 0.27 ms, within 9.5 ms of rise. With
that threshold and period, the rate of ON events is no test of the sensor; the others are."""
FALLS = {"equal rise and fall": 0.5, "sudden fall": 0.05}
"""Share of the cycle in which the light falls; 0.05 is 0.5 ms (assumed)."""
_CYCLES = 30
_SAMPLES = 100
"""Samples per cycle; between them, the logarithm of the light is a straight line."""
_FEWEST = 3
"""Fewest intervals of a pixel whose variation is counted."""


@dataclass(frozen=True)
class Lamp:
    """Events of the pixels in a lamp.

    Attributes:
        on_hz: ON events per pixel and second [Hz].
        off_hz: OFF events per pixel and second [Hz].
        on_variation: coefficient of variation of the intervals between the ON events of a pixel,
            mean over the pixels; None if they are too few.
    """

    on_hz: float
    off_hz: float
    on_variation: float | None


def measure_lamp(
    config: SensorConfig, *, chip_lux: float, swing: float, fall: float, seed: int
) -> Lamp:
    """Show a flickering lamp to a group of pixels, and measure their events.

    Args:
        config: configuration of the sensor; its size is replaced.
        chip_lux: geometric mean of the illuminance on the chip [lux].
        swing: logarithm of the ratio of the brightest to the darkest light.
        fall: share of the cycle in which the light falls.
        seed: seed of the sensor.
    """
    bench = bench_sensor(config, width=SIZE, height=SIZE)
    base = uniform_frame(bench, float(chip_luminance(bench, chip_lux)))
    samples = []
    for k in range(_CYCLES * _SAMPLES + 1):
        phase = k / _SAMPLES % 1.0
        height = phase / (1.0 - fall) if phase < 1.0 - fall else (1.0 - phase) / fall
        gain = np.float32(math.exp(swing * (height - 0.5)))
        samples.append((round(1e6 * k / _SAMPLES / FLICKER_HZ), gain * base))
    recording = record(bench, samples, seed=seed)
    events = recording.events
    per_s = 1e6 / recording.duration_us
    on, off = (event_counts(events[events["p"] == p], recording.shape) for p in (True, False))
    return Lamp(
        on_hz=float(on.mean()) * per_s,
        off_hz=float(off.mean()) * per_s,
        on_variation=_variation(events[events["p"]]),
    )


def _variation(events: Events) -> float | None:
    """Return the mean coefficient of variation of the intervals within a pixel."""
    pixel = events["y"].astype(np.int64) * SIZE + events["x"]
    order = np.lexsort((events["t"], pixel))
    inside = np.diff(pixel[order]) == 0
    intervals, owner = np.diff(events["t"][order])[inside], pixel[order][1:][inside]
    groups = np.split(intervals, np.flatnonzero(np.diff(owner)) + 1)
    found = [x.std() / x.mean() for x in groups if x.size >= _FEWEST]
    return float(np.mean(found)) if found else None


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on a lamp on the mains."""
    found = {
        name: [
            measure_lamp(config, chip_lux=CHIP_LUX, swing=swing, fall=fall, seed=seed)
            for swing in SWINGS
        ]
        for name, fall in FALLS.items()
    }
    return Section(
        "Lamp on the mains",
        f"{SIZE}×{SIZE} pixels see a lamp of {CHIP_LUX:,.0f} lux on the chip at {FLICKER_HZ:g} Hz. "
        "The logarithm of its light rises and falls in straight lines: either equally fast, or it "
        f"falls in {1e3 * FALLS['sudden fall'] / FLICKER_HZ:g} ms. The published figures are those "
        "of the core of a lamp that is saturated in the frames, so that its light is not known.",
        [row for name, lamps in found.items() for row in _rows(name, lamps)],
        [_plot(name, lamps) for name, lamps in found.items()],
    )


def _rows(name: str, lamps: list[Lamp]) -> list[Quantity]:
    lamp, at = lamps[SWINGS.index(SWING)], f"{name}, {SWING:g} ln units"
    return [
        Quantity(f"ON events: {at}", "Hz", lamp.on_hz, sources.LAMP_ON_HZ),
        Quantity(f"OFF events: {at}", "Hz", lamp.off_hz, sources.LAMP_OFF_HZ),
        Quantity(
            f"variation of ON intervals: {at}", "", lamp.on_variation, sources.LAMP_ON_VARIATION
        ),
    ]


def _plot(name: str, lamps: list[Lamp]) -> Plot:
    return Plot(
        f"Events in the lamp, {name}",
        "swing of the light [ln units]",
        "events per pixel [Hz]",
        [
            series("ON", SWINGS, [lamp.on_hz for lamp in lamps], Style.LINE, 0),
            series("OFF", SWINGS, [lamp.off_hz for lamp in lamps], Style.LINE, 1),
        ],
    )
