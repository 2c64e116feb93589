"""Latency and jitter of the response to a step, against illuminance.

The luminance of a small spot doubles and falls back repeatedly, as in the laboratory. The spot is
small so that the readout does not dominate. Latency is the time from the step to the first ON event
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
    bench_sensor,
    chip_luminance,
    chip_lux_per_scene_lux,
    events_between,
    first_times_us,
    nan_for_none,
    record,
    time_constant_us,
    uniform_frame,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig

CONTRAST = math.log(2.0)
"""Size of the step [ln units of luminance]."""
SPOT_PX = 8
"""Side of the spot."""
_STEPS = 24
"""Steps for each pixel: they give its jitter to within 15 %, and that of all pixels to 2 %."""
_HOLD = 8.0
"""How long each luminance lasts, in time constants: 0.03 % of the step is left then."""
_LEAST_RESPONSES = 0.5
"""Share of steps with a response below which the median would describe the fast pixels alone."""
_BRIGHT_CHIP_LUX = 1000.0
"""Illuminance on the chip at which the sources give their minimum latencies [lux]."""


@dataclass(frozen=True)
class Latency:
    """Latency at one illuminance.

    Attributes:
        median_us: median over all pixels and steps [µs].
        pixel_jitter_us: standard deviation of a pixel from step to step, mean over pixels [µs].
        jitter_us: standard deviation over all pixels and steps [µs].
        response_share: share of steps to which a pixel responded.
    """

    median_us: float
    pixel_jitter_us: float
    jitter_us: float
    response_share: float


def measure_latency(config: SensorConfig, *, chip_lux: float, seed: int) -> Latency | None:
    """Measure the latency of ON events at one illuminance; None if few pixels respond.

    Args:
        config: configuration of the sensor; its size is replaced.
        chip_lux: illuminance on the chip before each step [lux].
        seed: seed of the sensor.
    """
    sensor = replace(
        bench_sensor(config, width=SPOT_PX, height=SPOT_PX),
        readout=config.readout,
    )
    hold_us = math.ceil(_HOLD * time_constant_us(config, chip_lux)) + 100
    base = uniform_frame(sensor, chip_luminance(sensor, chip_lux))
    recording = record(sensor, _square_wave(base, hold_us), seed=seed)
    on = recording.events[recording.events["p"]]
    starts = [(2 * k + 1) * hold_us for k in range(_STEPS)]
    times = np.array(
        [first_times_us(events_between(on, t, t + hold_us), recording.shape) - t for t in starts]
    )
    response_share = float(np.isfinite(times).mean())
    if response_share < _LEAST_RESPONSES:
        return None
    enough = np.isfinite(times).sum(axis=0) > 1
    per_pixel = np.nanstd(times[:, enough], axis=0, ddof=1)
    return Latency(
        float(np.nanmedian(times)), float(per_pixel.mean()), float(np.nanstd(times)), response_share
    )


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on latency and jitter."""
    scale = chip_lux_per_scene_lux(config)
    found = [measure_latency(config, chip_lux=lux * scale, seed=seed) for lux in SCENE_LUX]
    bright = measure_latency(config, chip_lux=_BRIGHT_CHIP_LUX, seed=seed)
    best = None if bright is None else bright.median_us
    name = "latency at 1 klux on the chip"
    note = "conditions differ: the sources use different contrasts and biases"
    quantities = [
        Quantity(name, "µs", best, sources.LATENCY_BEST_US, note),
        Quantity(name, "µs", best, sources.LATENCY_MAKER_US, note),
        Quantity(name, "µs", best, sources.LATENCY_DAVIS240_US, note),
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
        f"The luminance of a spot of {SPOT_PX}×{SPOT_PX} pixels doubles within 1 µs and falls "
        f"back, {_STEPS} times. The latency is the time from the step to a pixel's first ON event. "
        "In dim light most first events are noise, and the latency is that of noise.",
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
        series(label, SCENE_LUX, nan_for_none(values), Style.LINE, colour_index)
        for colour_index, (label, values) in enumerate(columns.items())
    ]
    published = sources.LATENCY_BEST_US.value
    lines.append(series("Lichtsteiner 2008", [bright_lux], [published], Style.PUBLISHED))
    return Plot(
        "First ON event after a step of 2 to 1",
        "illuminance on the scene [lux]",
        "time [µs]",
        lines,
        x_log=True,
        y_log=True,
    )


def _square_wave(base: Frame, hold_us: int) -> list[tuple[int, Frame]]:
    """Return luminance that doubles at odd multiples of `hold_us` and falls back at even ones."""
    bright = np.asarray(base * np.exp(CONTRAST), np.float32)
    samples = [(0, base)]
    for k in range(1, 2 * _STEPS):
        before, after = (base, bright) if k % 2 else (bright, base)
        samples += [(k * hold_us, before), (k * hold_us + 1, after)]
    return [*samples, (2 * _STEPS * hold_us, samples[-1][1])]
