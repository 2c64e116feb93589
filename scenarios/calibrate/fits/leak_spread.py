"""How the leak differs from pixel to pixel, and hot pixels.

In bright light there is no noise, and leak gives each pixel ON events at regular intervals, of an
unknown phase: in a time in which the leak passes x thresholds, a pixel gives the whole number below
or above x, with the mean x. The counts of all pixels give the spread of x. The tail of pixels with
a high leak keeps the sensor's share and spread, which takes minutes of recording to tell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize

from emulator import SensorConfig
from emulator.characterisation import Plot, Quantity, Section, Style
from emulator.characterisation.section import series
from emulator.characterisation.settled_rates import settled_rates
from emulator.noise.leak import TAIL_FACTOR
from scenarios.calibrate.fit import Fit, Parameter, unknown
from scenarios.calibrate.fits.quiet_time import QuietTime

_FEWEST = 500
"""Fewest pixels from which a spread is estimated (assumed)."""
_LEAST_COUNT = 0.3
"""Least mean number of leak events of a pixel (assumed)."""
_NOISE_SHARE = 0.05
"""Largest OFF rate of noise, as a share of the ON rate, in light that counts as bright."""
_NODES = np.linspace(-3.5, 3.5, 71)
_MOST_COUNT = 60
_HOT_HZ = 10.0
"""Rate above which a quiet pixel is hot (assumed: beyond the leak's tail, see
`emulator.noise.leak`)."""
_HOT_RATIO = 10.0
_FEWEST_HOT_EVENTS = 5

F64 = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SpreadFit:
    """Spread of the leak.

    Attributes:
        spread: standard deviation of ln(leak) over most pixels.
        error: its standard error.
        counts: (k,) number of pixels with 0, 1, 2 … events.
        expected: (k,) the same, as fitted.
    """

    spread: float
    error: float
    counts: F64
    expected: F64


def hot_pixels(quiet: QuietTime) -> npt.NDArray[np.bool_]:
    """Return True at quiet pixels that are hot."""
    events = quiet.on + quiet.off
    rates = events / np.maximum(quiet.seconds, 1e-9)
    usual = float(events.sum() / max(float(quiet.seconds.sum()), 1e-9))
    limit = max(_HOT_HZ, _HOT_RATIO * usual)
    return np.asarray((rates > limit) & (events >= _FEWEST_HOT_EVENTS))


def fit_leak_spread(quiet: QuietTime, sensor: SensorConfig) -> SpreadFit | None:
    """Estimate the spread of the leak over the pixels; None if the recording does not tell it.

    Args:
        quiet: the quiet pixels, without hot ones.
        sensor: the sensor with fitted thresholds, noise and leak.
    """
    bright = _bright(quiet, sensor)
    if bright.lux.size < _FEWEST or float(bright.on.mean()) < _LEAST_COUNT:
        return None
    seconds = float(np.median(bright.seconds))
    same = bright.of(np.abs(bright.seconds - seconds) <= 0.1 * seconds)
    if same.lux.size < _FEWEST:
        return None
    counts = np.bincount(np.minimum(same.on, _MOST_COUNT), minlength=_MOST_COUNT + 1)

    def loss(logs: F64) -> float:
        chance = _chances(math.exp(logs[0]) * seconds, math.exp(logs[1]), sensor)
        return -float((counts * np.log(np.maximum(chance, 1e-12))).sum())

    start = np.log([max(float(same.on.mean()) / seconds / 1.5, 1e-4), 0.4])
    found = minimize(loss, start, method="Nelder-Mead", options={"maxfev": 300})
    logs = found.x
    step = np.array([0.0, 0.05])
    curvature = (loss(logs + step) - 2.0 * loss(logs) + loss(logs - step)) / 0.05**2
    error = 1.0 / math.sqrt(curvature) if curvature > 0.0 else math.inf
    spread = math.exp(logs[1])
    expected = same.lux.size * _chances(math.exp(logs[0]) * seconds, spread, sensor)
    return SpreadFit(spread, spread * error, counts.astype(np.float64), expected)


def _bright(quiet: QuietTime, sensor: SensorConfig) -> QuietTime:
    """Return the pixels in light in which noise is rare."""
    lux = np.geomspace(1e-3, 1e5, 60)
    on, off = settled_rates(sensor, lux).T
    noisy = np.flatnonzero(off > _NOISE_SHARE * np.maximum(on, 1e-9))
    limit = 0.0 if noisy.size == 0 else lux[min(noisy[-1] + 1, lux.size - 1)]
    return quiet.of(quiet.lux >= limit)


def _chances(median: float, spread: float, sensor: SensorConfig) -> F64:
    """Return the probability of each number of events, for a median of `median` thresholds."""
    weights = np.exp(-0.5 * _NODES**2)
    weights /= weights.sum()
    tail = sensor.leak_tail_fraction
    usual = median * np.exp(spread * _NODES)
    high = median * TAIL_FACTOR * np.exp(sensor.leak_tail_spread * _NODES)
    x = np.minimum(np.concatenate([usual, high]), _MOST_COUNT)
    share = np.concatenate([(1.0 - tail) * weights, tail * weights])
    numbers = np.arange(_MOST_COUNT + 1)
    return np.asarray(np.maximum(1.0 - np.abs(x[:, None] - numbers), 0.0).T @ share)


def leak_page(fit: SpreadFit | None, quiet: QuietTime, sensor: SensorConfig) -> Fit:
    """Return the spread of the leak and hot pixels, and the counts of the pixels.

    Args:
        fit: spread of the leak.
        quiet: the quiet pixels, with hot ones.
        sensor: the sensor with fitted leak.
    """
    method = (
        "Numbers of ON events of bright quiet pixels, where leak alone gives events. A quiet pixel "
        f"is hot above {_HOT_HZ:g} Hz, if that is {_HOT_RATIO:g} times the usual rate, and if "
        "the tail of the leak does not explain it."
    )
    hot = hot_pixels(quiet)
    rates = ((quiet.on + quiet.off) / np.maximum(quiet.seconds, 1e-9))[hot]
    pixels = quiet.lux.size
    parameters = [_spread_parameter(fit)]
    names = ("hot_fraction", "hot_hz_min", "hot_hz_max")
    if pixels < _FEWEST:
        reason = f"{pixels} pixels are quiet, fewer than {_FEWEST}"
        parameters += [unknown(name, "", reason) for name in names]
    else:
        number, in_tail = int(hot.sum()), pixels * _tail_share(sensor)
        is_more = number > in_tail + 3.0 * math.sqrt(in_tail) + 1.0
        evidence = f"{number} of {pixels:,} quiet pixels, {in_tail:.2g} of which the leak explains"
        share = (number - in_tail) / pixels if is_more else 0.0
        rates = rates if is_more else rates[:0]
        parameters.append(Parameter("hot_fraction", "", share, None, evidence))
        ends = ("hot_hz_min", rates.min(initial=np.inf)), ("hot_hz_max", rates.max(initial=0.0))
        parameters += [
            Parameter(name, "Hz", float(value), None, evidence)
            if rates.size
            else unknown(name, "Hz", "no pixels are hot but those in the leak's tail")
            for name, value in ends
        ]
    plots = [] if fit is None else [_plot(fit)]
    rows = (Quantity("quiet pixels", "", float(pixels)),)
    section = Section("Leak over the pixels, and hot pixels", method, rows, plots)
    return Fit("leak", tuple(parameters), section)


def _tail_share(sensor: SensorConfig) -> float:
    """Return the share of pixels whose leak alone exceeds the limit of hot pixels."""
    leak_hz = max(sensor.warm_leak_hz, 1e-9) * TAIL_FACTOR
    deviations = math.log(_HOT_HZ / leak_hz) / max(sensor.leak_tail_spread, 1e-3)
    return 0.5 * sensor.leak_tail_fraction * math.erfc(deviations / math.sqrt(2.0))


def _spread_parameter(fit: SpreadFit | None) -> Parameter:
    if fit is None:
        reason = "bright quiet pixels have too few leak events; record for longer"
        return unknown("leak_spread", "", reason)
    half = 1.96 * fit.error
    if half > 0.5 * max(fit.spread, 0.2):
        return unknown("leak_spread", "", f"{fit.spread:.2g} ± {half:.2g} is too uncertain")
    evidence = f"from {int(fit.counts.sum()):,} bright quiet pixels"
    interval = max(fit.spread - half, 0.0), fit.spread + half
    return Parameter("leak_spread", "", fit.spread, interval, evidence)


def _plot(fit: SpreadFit) -> Plot:
    last = int(np.flatnonzero(fit.counts)[-1]) + 2
    numbers = np.arange(last)
    seen = np.where(fit.counts[:last] > 0, fit.counts[:last], np.nan)
    expected = np.where(fit.expected[:last] > 0.1, fit.expected[:last], np.nan)
    return Plot(
        "Leak events of a pixel",
        "ON events",
        "number of pixels",
        [series("pixels", numbers, seen), series("fit", numbers, expected, Style.LINE)],
        y_log=True,
    )
