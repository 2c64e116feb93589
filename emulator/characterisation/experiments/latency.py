"""Latency and jitter of the answer to a step, against light.

The light of a small spot doubles and falls back, over and over, as in the laboratory; a small spot,
so that the readout is not what is measured. Latency is the time from the step to the first ON event
of a pixel. Jitter is given twice: of one pixel from step to step, and over all pixels and steps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    SCENE_LUX,
    Frame,
    between,
    chip_luminance,
    chip_lux_per_scene_lux,
    first_times_us,
    of_light,
    record,
    resized,
    time_constant_us,
    uniform,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig

CONTRAST = math.log(2.0)
"""Of the step [ln units of light]."""
SPOT_PX = 8
"""Side of the spot."""
_STEPS = 24
"""Of each pixel: its jitter is known to 15 %, that of the spot's pixels to 2 %."""
_HOLD = 8.0
"""How long each light stays, in time constants: 0.03 % of the step is left then."""
_LEAST_ANSWERS = 0.5
"""Share of steps answered below which a median latency would be one of the quick pixels alone."""
_BRIGHT_CHIP_LUX = 1000.0
"""Where the sources give their least latencies."""


@dataclass(frozen=True)
class Latency:
    """Latency at one light.

    Attributes:
        median_us: of all pixels and steps [µs].
        pixel_jitter_us: standard deviation of a pixel from step to step, mean over pixels [µs].
        jitter_us: standard deviation over all pixels and steps [µs].
        answered: share of steps that a pixel answered.
    """

    median_us: float
    pixel_jitter_us: float
    jitter_us: float
    answered: float


def measure_latency(config: SensorConfig, *, chip_lux: float, seed: int) -> Latency | None:
    """Latency of ON events at one light on the chip [lux]; None where few pixels answer."""
    sensor = replace(resized(config, width=SPOT_PX, height=SPOT_PX), readout=config.readout)
    hold_us = math.ceil(_HOLD * time_constant_us(config, chip_lux)) + 100
    base = uniform(sensor, chip_luminance(sensor, chip_lux))
    recording = record(sensor, _square_wave(base, hold_us), seed=seed)
    on = recording.events[recording.events["p"]]
    starts = [(2 * k + 1) * hold_us for k in range(_STEPS)]
    times = np.array(
        [first_times_us(between(on, t, t + hold_us), recording.shape) - t for t in starts]
    )
    answered = float(np.isfinite(times).mean())
    if answered < _LEAST_ANSWERS:
        return None
    enough = np.isfinite(times).sum(axis=0) > 1
    per_pixel = np.nanstd(times[:, enough], axis=0, ddof=1)
    return Latency(
        float(np.nanmedian(times)), float(per_pixel.mean()), float(np.nanstd(times)), answered
    )


def measure(config: SensorConfig, *, seed: int) -> Section:
    """The latencies of the data sheet."""
    scale = chip_lux_per_scene_lux(config)
    found = [measure_latency(config, chip_lux=lux * scale, seed=seed) for lux in SCENE_LUX]
    bright = measure_latency(config, chip_lux=_BRIGHT_CHIP_LUX, seed=seed)
    best = None if bright is None else bright.median_us
    other = "conditions differ: the sources do not share one contrast, nor one set of biases"
    quantities = [
        Quantity("latency at 1 klux on the chip", "µs", best, sources.LATENCY_BEST_US, other),
        Quantity("the same", "µs", best, sources.LATENCY_MAKER_US, other),
        Quantity("the same", "µs", best, sources.LATENCY_DAVIS240_US, other),
        Quantity(
            "jitter over pixels at 1 klux on the chip",
            "µs",
            None if bright is None else bright.jitter_us,
        ),
        Quantity(
            "jitter of one pixel at 1 klux on the chip",
            "µs",
            None if bright is None else bright.pixel_jitter_us,
        ),
    ]
    return Section(
        "Latency and jitter",
        f"A spot of {SPOT_PX}×{SPOT_PX} pixels sees the light double within 1 µs and fall back, "
        f"{_STEPS} times; time from the step to a pixel's first ON event. In dim light most first "
        "events are noise, and the latency is that of noise.",
        quantities,
        [_plot(found, _BRIGHT_CHIP_LUX / scale)],
    )


def _plot(found: list[Latency | None], bright_lux: float) -> Plot:
    columns = {
        "latency": [None if f is None else f.median_us for f in found],
        "jitter over pixels": [None if f is None else f.jitter_us for f in found],
        "jitter of one pixel": [None if f is None else f.pixel_jitter_us for f in found],
    }
    lines = [
        series(label, SCENE_LUX, of_light(values), Style.LINE, tint)
        for tint, (label, values) in enumerate(columns.items())
    ]
    published = sources.LATENCY_BEST_US.value
    lines.append(series("Lichtsteiner 2008", [bright_lux], [published], Style.PUBLISHED))
    return Plot(
        "First ON event after a step of 2 to 1",
        "light on the scene [lux]",
        "time [µs]",
        lines,
        x_log=True,
        y_log=True,
    )


def _square_wave(base: Frame, hold_us: int) -> list[tuple[int, Frame]]:
    """Light that doubles at odd multiples of `hold_us` and falls back at even ones."""
    bright = np.asarray(base * np.exp(CONTRAST), np.float32)
    samples = [(0, base)]
    for k in range(1, 2 * _STEPS):
        before, after = (base, bright) if k % 2 else (bright, base)
        samples += [(k * hold_us, before), (k * hold_us + 1, after)]
    return [*samples, (2 * _STEPS * hold_us, samples[-1][1])]
