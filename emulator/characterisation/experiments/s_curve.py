"""S-curves: the probability of an event against the contrast of a step, and fits to them.

A strong step down brings each pixel to the luminance of the test and resets it. The pixel is then
held in reset until its photoreceptor has settled. For this the refractory period is set long, as in
the laboratory (McReynolds et al. 2024), because a free pixel would already have leaked part of the
way to its threshold. Then comes one step of contrast c, in ln units of luminance. A pixel that
fires in the polarity of the step has responded. Over the pixels the probability is

    P(c) = g + (1 − g − l)·Φ((c − θ)/σ)

with the apparent threshold θ, the mismatch σ, the share g that fires by noise without a step, and
the share l that misses a step because of noise. In dim light the dark current E_d hides part of the
step and θ grows: exp(θ) − 1 = (1 + E_d/E)·(exp(θ_0) − 1). This gives the dark current.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import OptimizeWarning, curve_fit
from scipy.special import ndtr

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    SCENE_LUX,
    Frame,
    bench_sensor,
    chip_luminance,
    chip_lux_per_scene_lux,
    column_frame,
    event_counts,
    events_between,
    lux_label,
    nan_for_none,
    record,
    time_constant_us,
    uniform_frame,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig

WIDTH, HEIGHT = 64, 400
"""Columns, one for each contrast, and pixels that see each: they give a share to within 2.5 %."""
CONTROLS = 8
"""Columns without a step, in which only noise fires."""
REFERENCE_LUX = 1e3
"""Illuminance on the scene whose fits are listed in the table [lux]."""
_RESET_RATIO = 20.0
"""Luminance ratio of the step that resets: three ln units, many times any threshold."""
_SETTLING = 8.0
"""How long the pixels are held in reset, in time constants: a thousandth of a ln unit is then left
of the step that reset them."""
_READY = 0.4
"""Wait until the last pixels leave reset, in time constants; later, noise would come first."""
_WINDOW = 5.0
"""How long to wait for a response, in time constants: 0.7 % of the step is still missing then."""
_LEAST_RESPONSE = 0.3
"""Share of pixels, beyond noise, that must respond to the largest steps for a fit."""
_NOISY = 0.15
"""Share of noise above which a threshold is not used for the dark current. Such a threshold comes
out too high, since noise resets pixels that were about to fire."""
_NOTE = "noise carries pixels across earlier, so that the threshold appears lower than it is"
_GREATEST_CONTRAST = 4.0
"""Largest step [ln units]: 55 to 1."""

Contrasts = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SCurve:
    """One S-curve and its fit.

    Attributes:
        contrast: (n,) size of the steps [ln units].
        probability: (n,) share of pixels that responded.
        threshold: fitted θ [ln units]; None if the pixels do not respond.
        mismatch: fitted σ [ln units]; None if the pixels do not respond.
        guess: g, share of pixels that fire without a step.
        lapse: l, share of pixels that miss even the largest steps.
    """

    contrast: Contrasts
    probability: Contrasts
    threshold: float | None
    mismatch: float | None
    guess: float
    lapse: float


def measure_s_curve(config: SensorConfig, *, chip_lux: float, on: bool, seed: int) -> SCurve:
    """Measure the S-curve of one polarity at one illuminance: coarsely first, then on a fine grid.

    Args:
        config: configuration of the sensor; its size and refractory period are replaced.
        chip_lux: illuminance on the chip before the step [lux].
        on: True for steps up, False for steps down.
        seed: seed of the sensor.
    """
    coarse = np.geomspace(0.01, _GREATEST_CONTRAST, WIDTH - CONTROLS)
    found = fit_s_curve(
        coarse,
        *response_share(config, coarse, chip_lux=chip_lux, on=on, seed=seed, height=HEIGHT // 3),
    )
    if found.threshold is None:
        return found
    greatest = min(2.5 * found.threshold, _GREATEST_CONTRAST)
    fine = np.linspace(0.1 * found.threshold, greatest, WIDTH - CONTROLS)
    return fit_s_curve(
        fine, *response_share(config, fine, chip_lux=chip_lux, on=on, seed=seed, height=HEIGHT)
    )


def response_share(
    config: SensorConfig,
    contrast: Contrasts,
    *,
    chip_lux: float,
    on: bool,
    seed: int,
    height: int,
) -> tuple[Contrasts, float]:
    """Measure the share of pixels that respond to a step.

    Args:
        config: configuration of the sensor; its size and refractory period are replaced.
        contrast: (n,) sizes of the steps, one for each column [ln units].
        chip_lux: illuminance on the chip before the step [lux].
        on: True for steps up, False for steps down.
        seed: seed of the sensor.
        height: pixels that see each step.

    Returns:
        (n,) shares, and the share of the control columns, which see no step.
    """
    tau_us = time_constant_us(config, chip_lux)
    hold_us = min(math.ceil(_SETTLING * tau_us), 1_000_000)
    sensor = bench_sensor(config, width=contrast.size + CONTROLS, height=height)
    sensor = replace(sensor, refractory_us=max(hold_us, config.refractory_us))
    steps = np.concatenate((contrast, np.zeros(CONTROLS)))
    base = chip_luminance(config, chip_lux)
    after = column_frame(sensor, base * np.exp(steps if on else -steps))
    step_us = 1000 + sensor.refractory_us + math.ceil(_READY * tau_us) + 20
    end_us = step_us + math.ceil(_WINDOW * tau_us) + 20
    samples = _step_samples(uniform_frame(sensor, base), after, step_us=step_us, end_us=end_us)
    recording = record(sensor, samples, seed=seed)
    late = events_between(recording.events, step_us, end_us)
    fired = event_counts(late[late["p"] == on], recording.shape) > 0
    share = fired.mean(axis=0)
    return share[: contrast.size], float(share[contrast.size :].mean())


def fit_s_curve(contrast: Contrasts, probability: Contrasts, guess: float) -> SCurve:
    """Fit θ, σ and l to an S-curve with a known share of noise."""
    top = float(np.sort(probability)[-5:].mean())
    if top - guess < _LEAST_RESPONSE * (1.0 - guess):
        return SCurve(contrast, probability, None, None, guess, 1.0 - guess)
    half = guess + 0.5 * (top - guess)
    start = float(contrast[int(np.argmax(probability >= half))])

    def model(c: Contrasts, theta: float, sigma: float, lapse: float) -> Contrasts:
        share = ndtr((c - theta) / sigma)
        return np.asarray(guess + (1.0 - guess - lapse) * share, np.float64)

    lapse = min(max(1.0 - top, 0.0), 1.0 - guess)
    error = np.sqrt(probability * (1.0 - probability) / HEIGHT + 1.0 / HEIGHT**2)
    bounds = ([1e-4, 1e-4, 0.0], [2.0 * _GREATEST_CONTRAST, 3.0, 1.0 - guess + 1e-9])
    first_guess = (max(start, 2e-4), max(0.15 * start, 2e-4), lapse)
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", OptimizeWarning)
        fitted, _ = curve_fit(model, contrast, probability, first_guess, error, bounds=bounds)
    theta, sigma, lapse = (float(value) for value in fitted)
    return SCurve(contrast, probability, theta, sigma, guess, lapse)


def fit_dark_lux(chip_lux: npt.ArrayLike, threshold: npt.ArrayLike) -> float | None:
    """Estimate the dark current from apparent ON thresholds against illuminance.

    Args:
        chip_lux: (n,) illuminance on the chip [lux].
        threshold: (n,) apparent thresholds, NaN where there is none [ln units].

    Returns:
        Illuminance on the chip that causes a photocurrent equal to the dark current [lux]; None if
        fewer than three thresholds are known.
    """
    lux, theta = np.asarray(chip_lux, np.float64), np.asarray(threshold, np.float64)
    known = np.isfinite(theta)
    if np.count_nonzero(known) < 3:
        return None
    slope, hidden = np.polyfit(1.0 / lux[known], np.expm1(theta[known]), 1)
    return max(0.0, float(slope / hidden))


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on contrast thresholds."""
    scale = chip_lux_per_scene_lux(config)
    curves = {
        on: [measure_s_curve(config, chip_lux=lux * scale, on=on, seed=seed) for lux in SCENE_LUX]
        for on in (True, False)
    }
    return Section(
        "Contrast threshold (S-curves)",
        "A grey card of 18 % reflectance shows luminance steps of many sizes, each seen by 400 "
        "pixels that have just been reset. The curves show the share of pixels that respond in the "
        "polarity of the step. Threshold and mismatch are the mean and the standard deviation of "
        "the normal distribution fitted to a curve. The share that fires by noise is measured on "
        "pixels without a step. In dim light the dark current hides part of each step, so the "
        "apparent threshold grows; the dark current follows from that growth.",
        _quantities(curves, scale),
        [*(_curve_plot(curves[on], on) for on in (True, False)), _threshold_plot(curves)],
    )


def _quantities(curves: dict[bool, list[SCurve]], scale: float) -> list[Quantity]:
    at = SCENE_LUX.index(REFERENCE_LUX)
    quantities = []
    for on, name in ((True, "ON"), (False, "OFF")):
        theta, mismatch = curves[on][at].threshold, curves[on][at].mismatch
        nominal = sources.THETA_ON if on else sources.THETA_OFF
        percent = None if mismatch is None else 100.0 * mismatch
        quantities += [
            Quantity(f"{name} threshold at 1 klux", "ln units", theta, nominal, _NOTE),
            Quantity(f"{name} mismatch at 1 klux", "%", percent, sources.MISMATCH_JOUBERT),
            Quantity(f"{name} mismatch at 1 klux", "%", percent, sources.MISMATCH),
            Quantity(f"{name} mismatch at 1 klux", "%", percent, sources.MISMATCH_DVS128),
        ]
    theta_on, theta_off = (curves[polarity][at].threshold for polarity in (True, False))
    ratio = None if theta_on is None or theta_off is None else theta_off / theta_on
    quantities += [
        Quantity("OFF over ON threshold at 1 klux", "", ratio, published)
        for published in (sources.THRESHOLD_RATIO, sources.THRESHOLD_RATIO_JOUBERT)
    ]
    thetas = nan_for_none([c.threshold if c.guess < _NOISY else None for c in curves[True]])
    dark = fit_dark_lux(np.array(SCENE_LUX) * scale, thetas)
    name = "dark current as illuminance on the chip"
    return [*quantities, Quantity(name, "lux", dark, sources.DARK_LUX)]


def _curve_plot(curves: list[SCurve], on: bool) -> Plot:
    lines = []
    for colour_index, (lux, curve) in enumerate(zip(SCENE_LUX, curves, strict=True)):
        lines.append(
            series(lux_label(lux), curve.contrast, curve.probability, Style.POINTS, colour_index)
        )
        if curve.threshold is not None and curve.mismatch is not None:
            c = np.geomspace(float(curve.contrast[0]), float(curve.contrast[-1]), 200)
            share = ndtr((c - curve.threshold) / curve.mismatch)
            fitted = curve.guess + (1.0 - curve.guess - curve.lapse) * share
            lines.append(series("", c, fitted, Style.LINE, colour_index))
    name = "ON" if on else "OFF"
    return Plot(
        f"{name} events against the size of a step",
        "step [ln units of luminance]",
        "share of pixels that respond",
        lines,
        x_log=True,
    )


def _threshold_plot(curves: dict[bool, list[SCurve]]) -> Plot:
    at, nominal = REFERENCE_LUX, [sources.THETA_ON.value, sources.THETA_OFF.value]
    lines = [
        series(
            name,
            SCENE_LUX,
            nan_for_none([c.threshold for c in curves[on]]),
            Style.LINE,
            colour_index,
        )
        for colour_index, (on, name) in enumerate(((True, "ON"), (False, "OFF")))
    ]
    lines.append(series("maker's biases", [at, at], nominal, Style.PUBLISHED))
    return Plot(
        "Apparent threshold against illuminance",
        "illuminance on the scene [lux]",
        "threshold [ln units]",
        lines,
        x_log=True,
    )


def _step_samples(
    base: Frame, after: Frame, *, step_us: int, end_us: int
) -> list[tuple[int, Frame]]:
    bright = np.asarray(_RESET_RATIO * base, np.float32)
    return [
        (0, bright),
        (999, bright),
        (1000, base),
        (step_us, base),
        (step_us + 1, after),
        (end_us, after),
    ]
