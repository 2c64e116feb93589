"""By how much the logarithm of the light changed at each event: the threshold, and a correction.

A pixel memorises the light at the end of its refractory period. What changes meanwhile is lost, so
an event on a steep edge stands for more than its threshold. The slope at the event follows from the
intervals to the events before and after.

Noise makes an event stand for less: it crosses the threshold while the noise helps, and some of
that noise is gone when the pixel memorises. On a slope, the noise at the crossing has the mean κ·σ,
which follows from the hazard of the pixel model (`emulator.noise.first_passage`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from emulator import SensorConfig
from emulator.noise.first_passage import decay_rate, surprise
from emulator.noise.photoreceptor_noise import noise_of
from flybench.kernels import compiled
from scenarios.calibrate.recording import PixelEvents

_LONGEST_GAIN = 1.0
"""Largest correction for the refractory period, in thresholds (assumed)."""
_FAR_US = 1e9
_DISTANCES = np.arange(2.0, 7.5, 0.5)
"""Distances of the threshold in the table of κ [σ]; noise farther away is neglected."""
_SPEEDS = np.geomspace(1e-3, 1e3, 49)
"""Slopes in the table of κ [σ per correlation time]."""
_STEP = 0.02
_LOWEST = -6.0

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EventSteps:
    """Change of the logarithm of the light at each event: gain × threshold + shift.

    Attributes:
        gain: (n,) thresholds.
        shift: (n,) change besides, positive upwards [ln units].
        lag_us: (pixels,) time by which the output of each pixel lags behind the light [µs].
    """

    gain: F32
    shift: F32
    lag_us: F64


def event_steps(
    events: PixelEvents, lux: F64, sensor: SensorConfig, theta_on: float, theta_off: float
) -> EventSteps:
    """Return the change at each event.

    Args:
        events: events by pixel.
        lux: (pixels,) illuminance on the chip [lux].
        sensor: refractory period, bandwidths and noise.
        theta_on: ON threshold [ln units].
        theta_off: OFF threshold [ln units].
    """
    gain, shift = (np.empty(events.t.size, np.float32) for _ in range(2))
    sigma, per_tau = noise_by_pixel(lux, sensor)
    table = _crossing_noise()
    _steps(
        events.t,
        events.on,
        events.offsets,
        float(sensor.refractory_us),
        theta_on,
        theta_off,
        sigma,
        per_tau,
        table,
        gain,
        shift,
    )
    return EventSteps(gain, shift, 1.0 / per_tau)


def noise_by_pixel(lux: F64, sensor: SensorConfig) -> tuple[F64, F64]:
    """Return standard deviation [ln units] and 1/correlation time [1/µs] of the noise.

    Args:
        lux: (pixels,) illuminance on the chip, dark current included [lux].
        sensor: bandwidths and noise.
    """
    sigma, per_tau = np.empty(lux.size), np.empty(lux.size)
    per_hz = 2.0 * math.pi * 1e-6
    follower_us = 1.0 / (per_hz * sensor.follower_hz) if sensor.follower_hz else 0.0
    _noise(
        np.maximum(lux, sensor.warm_dark_lux) * per_hz * sensor.bandwidth_hz_per_lux,
        per_hz * sensor.bandwidth_limit_hz,
        follower_us,
        sensor.noise_sigma,
        sigma,
        per_tau,
    )
    return sigma, per_tau


def _crossing_noise() -> F64:
    """Return κ for each of `_DISTANCES` and `_SPEEDS`."""
    table = np.empty((_DISTANCES.size, _SPEEDS.size))
    _fill(_DISTANCES, _SPEEDS, table)
    return table


@compiled
def _fill(distances: Any, speeds: Any, table: Any) -> None:
    for i in range(distances.size):
        for j in range(speeds.size):
            table[i, j] = _mean_distance(distances[i], speeds[j])


@compiled
def _mean_distance(start: float, speed: float) -> float:
    """Return the mean distance of the mean from the threshold when noise crosses it [σ]."""
    h, hazard, total, first = start, 0.0, 0.0, surprise(start)
    while h > _LOWEST:
        alive = math.exp(-(hazard + max(surprise(h) - first, 0.0)))
        total += alive * _STEP
        hazard += decay_rate(h) / speed * _STEP
        h -= _STEP
    return start - total


@compiled
def _noise(
    open_corner: Any, limit: float, follower_us: float, sigma_0: float, sigma: Any, per_tau: Any
) -> None:
    for i in range(open_corner.size):
        corner = min(open_corner[i], limit)
        noise = noise_of(sigma_0, corner, open_corner[i], follower_us)
        sigma[i], per_tau[i] = noise.sigma, noise.per_tau


@compiled
def _steps(
    t: Any,
    on: Any,
    offsets: Any,
    refractory_us: float,
    theta_on: float,
    theta_off: float,
    sigma: Any,
    per_tau: Any,
    table: Any,
    gain: Any,
    shift: Any,
) -> None:
    for i in range(offsets.size - 1):
        first, last = offsets[i], offsets[i + 1]
        lost = 1.0 - math.exp(-refractory_us * per_tau[i])
        for n in range(first, last):
            slope = _slope(t, on, n, first, last, refractory_us)
            gain[n] = 1.0 + min(refractory_us * slope, _LONGEST_GAIN)
            theta = theta_on if on[n] else theta_off
            noise = 0.0
            if sigma[i] > 0.0:
                speed = slope * theta / (per_tau[i] * sigma[i])
                noise = sigma[i] * lost * _interpolated(table, theta / sigma[i], speed)
            shift[n] = -noise if on[n] else noise


@compiled
def _slope(t: Any, on: Any, n: int, first: int, last: int, refractory_us: float) -> float:
    """Return the slope at event n, between those before and after it [thresholds/µs]."""
    before = after = _FAR_US
    slope_before = slope_after = 0.0
    if n > first:
        before = float(t[n] - t[n - 1])
        slope_before = _slope_of(before, refractory_us, on[n] == on[n - 1])
    if n + 1 < last:
        after = float(t[n + 1] - t[n])
        slope_after = _slope_of(after, refractory_us, on[n] == on[n + 1])
    return (before * slope_after + after * slope_before) / max(before + after, 1.0)


@compiled
def _slope_of(interval_us: float, refractory_us: float, same: bool) -> float:
    return 1.0 / max(interval_us - refractory_us, 0.5 * refractory_us + 1.0) if same else 0.0


@compiled
def _interpolated(table: Any, distance: float, speed: float) -> float:
    """Return κ between the entries of the table; 0 beyond its largest distance."""
    rows, columns = table.shape
    if distance > 7.0:
        return 0.0
    y = min(max((distance - 2.0) * 2.0, 0.0), rows - 1.001)
    x = (math.log10(max(speed, 1e-3)) + 3.0) * (columns - 1) / 6.0
    x = min(x, columns - 1.001)
    i, j = int(y), int(x)
    u, v = y - i, x - j
    upper = (1.0 - v) * table[i, j] + v * table[i, j + 1]
    lower = (1.0 - v) * table[i + 1, j] + v * table[i + 1, j + 1]
    return float((1.0 - u) * upper + u * lower)
