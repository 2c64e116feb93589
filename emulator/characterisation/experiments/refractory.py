"""The refractory period, recovered from how fast a pixel can fire.

The logarithm of the light climbs at a constant rate r until the photoreceptor, too, climbs at r.
After each event the pixel is in reset for T and then has θ to climb, so its intervals are
T + θ/r: a straight line in 1/r, whose intercept is T and whose slope is θ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    Frame,
    chip_luminance,
    record,
    resized,
    time_constant_us,
    uniform,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from flybench.events import Events

SIDE_PX = 4
"""Few, since every pixel of a seed shows the same period; mismatch averages over the seeds."""
_START_LUX, _END_LUX = 100.0, 1e6
"""On the chip: from where the biases limit the bandwidth to where leak begins to help [lux]."""
_SETTLING = 4.0
"""Time constants after which the photoreceptor climbs within 2 % of the light's rate."""
_SPEEDS = (1.0, 0.75, 0.5, 0.33, 0.25)
"""Of the ramps, over the fastest that the photoreceptor has the time to follow."""
_SEEDS = 8
"""Sensors: 128 pixels in all."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RefractoryFit:
    """Intervals against the time that a threshold takes, and the line through them.

    Attributes:
        us_per_ln: (n,) 1/r of the ramps [µs per ln unit].
        interval_us: (n,) mean interval between ON events of a pixel [µs].
        refractory_us: intercept T [µs], None where pixels fired too seldom.
        theta_on: slope θ [ln units], None likewise.
        shortest_us: least interval of a pixel that was seen [µs], None likewise.
    """

    us_per_ln: Floats
    interval_us: Floats
    refractory_us: float | None
    theta_on: float | None
    shortest_us: float | None


def measure_refractory(config: SensorConfig, *, seed: int) -> RefractoryFit:
    """Refractory period and mean ON threshold from ramps of several speeds."""
    sensor = resized(config, width=SIDE_PX, height=SIDE_PX)
    tau_us = time_constant_us(config, _START_LUX)
    climb = math.log(_END_LUX / _START_LUX)
    least_us = max((_SETTLING + 3.0) * tau_us, 20.0, 5.0 * config.refractory_us)
    slopes, means, shortest = [], [], []
    for speed in _SPEEDS:
        duration_us = math.ceil(least_us / speed)
        late = math.ceil(_SETTLING * tau_us)
        gaps = [_gaps(sensor, duration_us, late, seed + k) for k in range(_SEEDS)]
        per_pixel = [gap for run in gaps for gap in run if gap.size]
        if per_pixel:
            slopes.append(duration_us / climb)
            means.append(float(np.mean([gap.mean() for gap in per_pixel])))
            shortest.append(min(float(gap.min()) for gap in per_pixel))
    x, y = np.array(slopes), np.array(means)
    if x.size < len(_SPEEDS):
        return RefractoryFit(x, y, None, None, None)
    theta_on, period_us = np.polyfit(x, y, 1)
    return RefractoryFit(x, y, float(period_us), float(theta_on), min(shortest))


def measure(config: SensorConfig, *, seed: int) -> Section:
    """The refractory period of the data sheet."""
    found = measure_refractory(config, seed=seed)
    quantities = [
        Quantity("refractory period", "µs", found.refractory_us, sources.REFRACTORY_US),
        Quantity("shortest interval of a pixel", "µs", found.shortest_us),
        Quantity("mean ON threshold, from the slope", "ln units", found.theta_on, sources.THETA_ON),
    ]
    lines = [series("measured", found.us_per_ln, found.interval_us, Style.POINTS, 0)]
    if found.refractory_us is not None and found.theta_on is not None:
        x = np.linspace(0.0, found.us_per_ln.max(), 50)
        lines.append(series("fit", x, found.refractory_us + found.theta_on * x, Style.LINE, 0))
    return Section(
        "Refractory period",
        f"The logarithm of the light climbs at constant rates, by {_END_LUX / _START_LUX:.0e} in "
        f"all; intervals between ON events of {SIDE_PX}×{SIDE_PX} pixels once the photoreceptor "
        "climbs at the same rate. They are the refractory period and the time that the threshold "
        "takes: a line whose intercept is the one and whose slope is the other.",
        quantities,
        [
            Plot(
                "Intervals on a ramp of light",
                "time per ln unit of the ramp [µs]",
                "interval [µs]",
                lines,
            )
        ],
    )


def _gaps(sensor: SensorConfig, duration_us: int, late_us: int, seed: int) -> list[Floats]:
    """Intervals of each pixel in the steady part of a ramp [µs]."""
    recording = record(sensor, _ramp(sensor, duration_us), seed=seed)
    events = recording.events
    steady = events[events["p"] & (events["t"] > 1 + late_us)]
    return [_of_pixel(steady, x, y) for x in range(SIDE_PX) for y in range(SIDE_PX)]


def _of_pixel(events: Events, x: int, y: int) -> Floats:
    mine = events[(events["x"] == x) & (events["y"] == y)]
    return np.asarray(np.diff(mine["t"]), np.float64)


def _ramp(sensor: SensorConfig, duration_us: int) -> list[tuple[int, Frame]]:
    """Two samples are a ramp: between them the logarithm of the light is a straight line."""
    lux = (_START_LUX, _START_LUX, _END_LUX)
    times = (0, 1, 1 + duration_us)
    light = [uniform(sensor, chip_luminance(sensor, x)) for x in lux]
    return list(zip(times, light, strict=True))
