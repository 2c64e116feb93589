"""The refractory period, from the intervals of a pixel that fires as fast as it can.

The logarithm of the luminance rises at a constant rate r until the photoreceptor rises at r too.
After each event the pixel is in reset for T and then has to rise by θ. So its intervals are
T + θ/r: a straight line in 1/r with intercept T and slope θ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    Frame,
    bench_sensor,
    chip_luminance,
    record,
    time_constant_us,
    uniform_frame,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from flybench.events import Events

SIDE_PX = 4
"""Side of the array: small, since every pixel of a seed has the same period. Mismatch averages out
over the seeds."""
_START_LUX, _END_LUX = 100.0, 1e6
"""Illuminance on the chip: from where the biases limit the bandwidth to where leak starts to matter
[lux]."""
_SETTLING = 4.0
"""Time constants after which the photoreceptor rises within 2 % of the rate of the luminance."""
_SPEEDS = (1.0, 0.75, 0.5, 0.33, 0.25)
"""Speeds of the ramps, relative to the fastest that the photoreceptor has time to follow."""
_SAMPLES = 200
"""Samples of a ramp: noise falls as the light rises, and is constant between samples."""
_SEEDS = 8
"""Number of sensors, which gives 128 pixels in all."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RefractoryFit:
    """Intervals against the inverse rate of the ramps, and the line fitted to them.

    Attributes:
        us_per_ln: (n,) 1/r of the ramps [µs per ln unit].
        interval_us: (n,) mean interval between ON events of a pixel [µs].
        refractory_us: intercept T [µs]; None if pixels fired too seldom.
        theta_on: slope θ [ln units]; None if pixels fired too seldom.
        shortest_us: shortest interval of a pixel [µs]; None if pixels fired too seldom.
    """

    us_per_ln: Floats
    interval_us: Floats
    refractory_us: float | None
    theta_on: float | None
    shortest_us: float | None


def measure_refractory(config: SensorConfig, *, seed: int) -> RefractoryFit:
    """Measure refractory period and mean ON threshold with ramps of several speeds."""
    sensor = bench_sensor(config, width=SIDE_PX, height=SIDE_PX)
    tau_us = time_constant_us(config, _START_LUX)
    rise = math.log(_END_LUX / _START_LUX)
    least_us = max((_SETTLING + 3.0) * tau_us, 20.0, 5.0 * config.refractory_us)
    slopes, means, shortest = [], [], []
    for speed in _SPEEDS:
        duration_us = math.ceil(least_us / speed)
        settled_us = math.ceil(_SETTLING * tau_us)
        intervals = [
            _intervals_us(sensor, duration_us, settled_us, seed + k) for k in range(_SEEDS)
        ]
        per_pixel = [x for run in intervals for x in run if x.size]
        if per_pixel:
            slopes.append(duration_us / rise)
            means.append(float(np.mean([x.mean() for x in per_pixel])))
            shortest.append(min(float(x.min()) for x in per_pixel))
    x, y = np.array(slopes), np.array(means)
    if x.size < len(_SPEEDS):
        return RefractoryFit(x, y, None, None, None)
    theta_on, period_us = np.polyfit(x, y, 1)
    return RefractoryFit(x, y, float(period_us), float(theta_on), min(shortest))


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on the refractory period."""
    found = measure_refractory(config, seed=seed)
    quantities = [
        Quantity("refractory period", "µs", found.refractory_us, sources.REFRACTORY_US),
        Quantity("shortest interval of a pixel", "µs", found.shortest_us),
        Quantity("mean ON threshold, from the slope", "ln units", found.theta_on, sources.THETA_ON),
    ]
    lines = [series("measured", found.us_per_ln, found.interval_us, Style.POINTS, 0)]
    if found.refractory_us is not None and found.theta_on is not None:
        x = np.linspace(0.0, found.us_per_ln.max(), 50)
        fitted = found.refractory_us + found.theta_on * x
        lines.append(series("fitted line", x, fitted, Style.LINE, 0))
    return Section(
        "Refractory period",
        "The logarithm of the luminance rises at constant rates, by a factor of "
        f"{_END_LUX / _START_LUX:,.0f} in all. Intervals between ON events of {SIDE_PX}×{SIDE_PX} "
        "pixels are measured once the photoreceptor rises at the same rate. Each is the refractory "
        "period plus the time to the next threshold. Plotted against the inverse rate, they form a "
        "line: its intercept is the refractory period, its slope the threshold.",
        quantities,
        [
            Plot(
                "Intervals on a luminance ramp",
                "time per ln unit of the ramp [µs]",
                "interval [µs]",
                lines,
            )
        ],
    )


def _intervals_us(
    sensor: SensorConfig, duration_us: int, settled_us: int, seed: int
) -> list[Floats]:
    """Return the intervals of each pixel in the steady part of a ramp [µs]."""
    recording = record(sensor, _ramp(sensor, duration_us), seed=seed)
    events = recording.events
    steady = events[events["p"] & (events["t"] > 1 + settled_us)]
    return [_pixel_intervals_us(steady, x, y) for x in range(SIDE_PX) for y in range(SIDE_PX)]


def _pixel_intervals_us(events: Events, x: int, y: int) -> Floats:
    own = events[(events["x"] == x) & (events["y"] == y)]
    return np.asarray(np.diff(own["t"]), np.float64)


def _ramp(sensor: SensorConfig, duration_us: int) -> list[tuple[int, Frame]]:
    """Return samples of a ramp; the sensor interpolates the logarithm between them."""
    number = min(_SAMPLES, duration_us)
    lux = [_START_LUX, *np.geomspace(_START_LUX, _END_LUX, number + 1)]
    times = [0, *(1 + duration_us * k // number for k in range(number + 1))]
    frames = [uniform_frame(sensor, chip_luminance(sensor, x)) for x in lux]
    return list(zip(times, frames, strict=True))
