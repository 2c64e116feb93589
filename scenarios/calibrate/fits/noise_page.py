"""Noise and leak on the page: parameters, and the rates against illuminance."""

from __future__ import annotations

import math

import numpy as np

from emulator import SensorConfig
from emulator.characterisation import Plot, Section, Style
from emulator.characterisation.section import series
from emulator.characterisation.settled_rates import settled_rates
from scenarios.calibrate.fit import Fit, Parameter, unknown
from scenarios.calibrate.fits.noise import (
    DARKEST,
    FEWEST_ON,
    MOST_ERROR,
    NoiseFit,
    mean_leak_factor,
)

_FEWEST_OFF = 30
"""Fewest OFF events that tell the noise (assumed)."""
_LEAST_LEAK_SHARE = 0.1
"""Least share of the leak in the ON events of a class of pixels that tells the leak (assumed)."""


def noise_page(fit: NoiseFit | None) -> Fit:
    """Return noise, cutoff and leak, and the rates against illuminance."""
    title = "Noise and leak of quiet pixels"
    method = (
        "Rates of pixels whose light does not change, in classes of illuminance, and the rates "
        "that the equations of the pixel model give. The illuminance is that which the frames "
        "show, with the sensitivity of the frames that the sensor states."
    )
    names = {"noise_sigma": "ln units", "bandwidth_hz_per_lux": "Hz/lux", "leak_hz": "Hz"}
    if fit is None:
        missing = tuple(unknown(n, unit, "no pixel is quiet") for n, unit in names.items())
        return Fit("noise", missing, Section(title, method, ()))
    parameters = tuple(_parameter(fit, name, unit) for name, unit in names.items())
    per_lux = unknown("leak_hz_per_lux", "Hz/lux", "it shows only in light of some 1000 lux")
    section = Section(title, method, (), [_plot(fit)])
    return Fit("noise", (*parameters, per_lux), section)


def _parameter(fit: NoiseFit, name: str, unit: str) -> Parameter:
    classes, error = fit.classes, fit.error(name)
    value = float(getattr(fit.sensor, name))
    on, off = int(classes.on.sum()), int(classes.off.sum())
    if name == "leak_hz":
        number, fewest, kind = on, FEWEST_ON, "ON"
    else:
        number, fewest, kind = off, _FEWEST_OFF, "OFF"
    if number < fewest:
        return unknown(name, unit, f"quiet pixels give {number} {kind} events, fewer than {fewest}")
    hidden = fit.leak_share < _LEAST_LEAK_SHARE and fit.most_leak_hz > fit.start.leak_hz
    if name == "leak_hz" and hidden:
        return unknown(name, unit, "noise hides it at every illuminance of the quiet pixels")
    refuted = fit.most_leak_hz < fit.start.leak_hz * _settling_share(fit.sensor)
    if name == "leak_hz" and not fit.has_settled and not refuted:
        reason = (
            "after motion, pixels need a leak period to settle, so the camera has to be still "
            f"first; it would be {value:.2g} Hz if they had settled"
        )
        return unknown(name, unit, reason)
    if error > 2.0 * MOST_ERROR:
        reason = "the rates of quiet pixels hardly depend on it"
        return unknown(name, unit, reason)
    interval = value * math.exp(-1.96 * error), value * math.exp(1.96 * error)
    seconds, pixels = float(classes.seconds.sum()), int(classes.pixels.sum())
    evidence = (
        f"from {on:,} ON and {off:,} OFF events of {pixels:,} quiet pixels in {seconds:,.0f} "
        f"pixel seconds, {classes.lux[0]:.2g} to {classes.lux[-1]:.2g} lux"
    )
    return Parameter(name, unit, value, interval, evidence)


def _settling_share(sensor: SensorConfig) -> float:
    """Return the rate of leak events soon after motion, over that of settled pixels.

    Motion leaves the memory anywhere between the thresholds, not only below the ON threshold.
    """
    return sensor.theta_on / (sensor.theta_on + sensor.theta_off)


def _plot(fit: NoiseFit) -> Plot:
    classes = fit.classes
    shown_lux = np.maximum(classes.lux, DARKEST)
    lux = np.geomspace(0.5 * shown_lux.min(), 2.0 * shown_lux.max(), 25)
    rates = settled_rates(fit.sensor, lux, leak_factor=mean_leak_factor(fit.sensor))
    curves = []
    for k, (name, counts) in enumerate((("ON", classes.on), ("OFF", classes.off))):
        seen = np.where(counts > 0, counts / classes.seconds, np.nan)
        curves.append(series(name, shown_lux, seen, Style.POINTS, k))
        shown = np.where(rates[:, k] > 1e-5, rates[:, k], np.nan)
        curves.append(series(f"{name}, fit", lux, shown, Style.LINE, k))
    return Plot(
        "Events of quiet pixels",
        "illuminance on the chip [lux]",
        "rate of a pixel [Hz]",
        curves,
        x_log=True,
        y_log=True,
    )
