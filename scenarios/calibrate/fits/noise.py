"""Noise of the photoreceptor and leak, from the events of quiet pixels against their illuminance.

The equations of the pixel model give the rates of ON and OFF events of pixels in constant light
(`emulator.characterisation.settled_rates`). Noise, leak and the cutoff per lux are those under
which the counts are most likely. Leak alone gives ON events; noise gives both polarities, and the
more equal they are the more it prevails: θ_on·R_on − θ_off·R_off is the leak, whatever the noise,
as long as the noise is slower than the refractory period.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize

from emulator import SensorConfig
from emulator.characterisation.settled_rates import settled_rates
from emulator.noise.leak import TAIL_FACTOR
from scenarios.calibrate.fits.quiet_time import QuietTime

_FEWEST_PIXELS = 50
_FEWEST_CLASSES = 4
"""Fewest classes of illuminance that tell the cutoff per lux (assumed)."""
_LEAST_SECONDS = 5.0
"""Least quiet time of a class, over all its pixels [s] (assumed)."""
FEWEST_ON = 50
"""Fewest ON events that tell the leak (assumed)."""
MOST_ERROR = 0.15
"""Largest standard error of a logarithm that counts as told (assumed)."""
_LEAST_SETTLED = 0.5
"""Least share of pixels that were still from the start and tell the leak (assumed)."""
_STEP = 0.05
DARKEST = 1e-3
"""Illuminance below which all pixels are one class [lux]."""
_BOUNDS = ((math.log(1e-3), math.log(1.0)), (math.log(1e-4), math.log(100.0)), (-7.0, 12.0))
"""Ranges of the logarithms of σ0, leak [Hz] and cutoff per lux [Hz/lux]."""

F64 = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LightClasses:
    """Events of the quiet pixels in classes of illuminance, each (n,).

    Attributes:
        lux: mean illuminance [lux].
        seconds: quiet time of all pixels together [s].
        on: number of ON events.
        off: number of OFF events.
        pixels: number of pixels.
        excess: variance of the counts of the pixels over their mean, at least 1.
        settled: share of the pixels whose quiet time starts with the recording.
    """

    lux: F64
    seconds: F64
    on: F64
    off: F64
    pixels: F64
    excess: F64
    settled: F64


@dataclass(frozen=True, eq=False)
class NoiseFit:
    """Noise and leak.

    Attributes:
        sensor: the sensor with these values.
        names: parameters that were fitted.
        errors: standard error of the logarithm of each.
        classes: what they were fitted to.
        start: sensor from which the fit started.
    """

    sensor: SensorConfig
    names: tuple[str, ...]
    errors: tuple[float, ...]
    classes: LightClasses
    start: SensorConfig

    @property
    def leak_share(self) -> float:
        """Largest share of the leak in the ON events of a class with enough of them."""
        c = self.classes
        leak = self.sensor.warm_leak_hz + self.sensor.leak_hz_per_lux * c.lux
        share = mean_leak_factor(self.sensor) * leak * c.seconds / np.maximum(c.on, 1.0)
        return float(share[c.on >= FEWEST_ON / 2].max(initial=0.0))

    @property
    def has_settled(self) -> bool:
        """True if pixels had settled, at the start of the recording or long after motion."""
        c = self.classes
        mean_s = float(c.seconds.sum() / c.pixels.sum())
        settled = float(np.average(c.settled, weights=c.pixels))
        return settled >= _LEAST_SETTLED or mean_s * self.sensor.leak_hz > 1.0

    @property
    def most_leak_hz(self) -> float:
        """Highest median leak that the ON events of every class allow, with 95 % confidence."""
        c = self.classes
        most = (c.on + 2.0 * np.sqrt(c.excess * (c.on + 1.0))) / c.seconds
        return float(most.min()) / mean_leak_factor(self.sensor)

    def error(self, name: str) -> float:
        """Return the standard error of the logarithm of a parameter; infinite if not fitted."""
        return dict(zip(self.names, self.errors, strict=True)).get(name, math.inf)


def light_classes(quiet: QuietTime) -> LightClasses:
    """Return the quiet pixels in classes of illuminance, a factor of three wide."""
    octave = np.floor(np.log(np.maximum(quiet.lux, DARKEST)) / math.log(3.0)).astype(np.int64)
    rows = []
    for number in np.unique(octave):
        part = quiet.of(octave == number)
        seconds = float(part.seconds.sum())
        if part.lux.size < _FEWEST_PIXELS or seconds < _LEAST_SECONDS:
            continue
        counts = part.on + part.off
        excess = max(1.0, float(counts.var()) / max(float(counts.mean()), 1e-9))
        lux = float(np.average(part.lux, weights=part.seconds))
        number = part.on.sum(), part.off.sum(), part.lux.size
        rows.append((lux, seconds, *number, excess, part.settled.mean()))
    return LightClasses(*np.array(rows, np.float64).reshape(-1, 7).T)


def mean_leak_factor(sensor: SensorConfig) -> float:
    """Return the mean leak of the pixels over the median."""
    tail = sensor.leak_tail_fraction
    return (1.0 - tail) * math.exp(sensor.leak_spread**2 / 2) + tail * TAIL_FACTOR * math.exp(
        sensor.leak_tail_spread**2 / 2
    )


def fit_noise(quiet: QuietTime, sensor: SensorConfig, *, cutoff: bool = True) -> NoiseFit | None:
    """Estimate noise, leak and, if it shows, the cutoff per lux; None without quiet pixels.

    Args:
        quiet: the quiet pixels.
        sensor: thresholds, mismatch, refractory period, and the start of the fit.
        cutoff: False to keep the cutoff per lux.
    """
    classes = light_classes(quiet)
    if classes.lux.size == 0:
        return None
    names: tuple[str, ...] = ("noise_sigma", "leak_hz")
    best, errors = _fit(classes, sensor, names)
    if cutoff and classes.lux.size >= _FEWEST_CLASSES:
        more = (*names, "bandwidth_hz_per_lux")
        found, found_errors = _fit(classes, best, more)
        if found_errors[2] <= 2.0 * MOST_ERROR:
            return NoiseFit(found, more, found_errors, classes, sensor)
    return NoiseFit(best, names, errors, classes, sensor)


def _fit(
    classes: LightClasses, sensor: SensorConfig, names: tuple[str, ...]
) -> tuple[SensorConfig, tuple[float, ...]]:
    """Return the most likely sensor, and the standard error of the logarithm of each parameter."""
    bounds = np.array(_BOUNDS[: len(names)])

    def loss(logs: F64) -> float:
        inside = np.clip(logs, bounds[:, 0], bounds[:, 1])
        beyond = float(np.abs(logs - inside).sum())
        return _loss(classes, _changed(sensor, names, inside)) + 100.0 * beyond

    start = np.log([max(getattr(sensor, name), 0.01) for name in names])
    simplex = np.vstack([start, start + 0.3 * np.eye(len(names))])
    options = {"xatol": 0.003, "fatol": 0.01, "maxfev": 120, "initial_simplex": simplex}
    found = minimize(loss, start, method="Nelder-Mead", options=options)
    logs = np.clip(found.x, bounds[:, 0], bounds[:, 1])
    return _changed(sensor, names, logs), _errors(loss, logs)


def _changed(sensor: SensorConfig, names: tuple[str, ...], logs: F64) -> SensorConfig:
    return replace(sensor, **dict(zip(names, np.exp(logs).tolist(), strict=True)))


def _loss(classes: LightClasses, sensor: SensorConfig) -> float:
    """Return minus the log likelihood of the counts, divided by their excess variance."""
    rates = settled_rates(sensor, classes.lux, leak_factor=mean_leak_factor(sensor))
    expected = np.maximum(rates.T * classes.seconds, 1e-6)
    counts = np.stack([classes.on, classes.off])
    return float(((expected - counts * np.log(expected)) / classes.excess).sum())


def _errors(loss: Callable[[F64], float], logs: F64) -> tuple[float, ...]:
    """Return standard errors from the curvature of the log likelihood."""
    size = logs.size
    steps = _STEP * np.eye(size)
    curvature = np.empty((size, size))
    for i in range(size):
        for j in range(size):
            signs = ((1, 1), (1, -1), (-1, 1), (-1, -1))
            values = [s * t * loss(logs + s * steps[i] + t * steps[j]) for s, t in signs]
            curvature[i, j] = sum(values) / (4.0 * _STEP**2)
    try:
        variances = np.diag(np.linalg.inv(curvature))
    except np.linalg.LinAlgError:
        return (math.inf,) * size
    return tuple(math.sqrt(v) if v > 0.0 else math.inf for v in variances.tolist())
