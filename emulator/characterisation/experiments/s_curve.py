"""S-curves: the probability of an event against the contrast of a step, and what they tell.

Each pixel is brought to the light of the test by a strong step down, which resets it, and held in
reset until its photoreceptor has settled: the refractory period is set long for that, as in the
laboratory (McReynolds et al. 2024), since a pixel that is left to itself has leaked part of the way
to its threshold already. Then comes one step of contrast c, in natural logarithms of the light,
and whoever fires in the right polarity has responded. Over the pixels the probability is

    P(c) = g + (1 − g − l)·Φ((c − θ)/σ)

with the apparent threshold θ, the mismatch σ, the share g that noise makes fire without a step, and
the share l that noise makes miss one. In dim light the dark current E_d hides part of the step, and
θ grows: exp(θ) − 1 = (1 + E_d/E)·(exp(θ_0) − 1), which gives the dark current away.
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
    between,
    chip_luminance,
    chip_lux_per_scene_lux,
    columns,
    counts,
    light_label,
    of_light,
    record,
    resized,
    time_constant_us,
    uniform,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig

WIDTH, HEIGHT = 64, 400
"""Columns, one a contrast, and pixels that see each: a share is known to 2.5 %."""
CONTROLS = 8
"""Columns that see no step; what fires there is noise."""
REFERENCE_LUX = 1e3
"""Light on the scene whose fits stand in the table."""
_RESET_RATIO = 20.0
"""Of the step that resets: three ln units, many times any threshold."""
_SETTLING = 8.0
"""How long the pixels are held in reset, in time constants: a thousandth of a ln unit is left of
the step that reset them."""
_READY = 0.4
"""Wait for the last pixels to leave reset, in time constants: longer, and noise comes first."""
_WINDOW = 5.0
"""How long an answer is waited for, in time constants; 0.7 % of the step is still to come then."""
_LEAST_RESPONSE = 0.3
"""Share of pixels, beyond what noise does, that must answer the largest steps for a fit."""
_NOISY = 0.15
"""Share of noise above which a threshold is not used to find the dark current: it comes out high,
since noise resets pixels that were on their way."""
_GREATEST_CONTRAST = 4.0
"""Of the steps [ln units]: 55 to 1."""

Contrasts = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SCurve:
    """One S-curve and its fit.

    Attributes:
        contrast: (n,) size of the steps [ln units].
        probability: (n,) share of pixels that responded.
        threshold: fitted θ [ln units], None where the pixels do not respond.
        mismatch: fitted σ [ln units], None likewise.
        guess: g, share of pixels that fire without a step.
        lapse: l, share that fire at no contrast.
    """

    contrast: Contrasts
    probability: Contrasts
    threshold: float | None
    mismatch: float | None
    guess: float
    lapse: float


def measure_s_curve(config: SensorConfig, *, chip_lux: float, on: bool, seed: int) -> SCurve:
    """S-curve of one polarity at one light: a search for the threshold, then a fine grid.

    Args:
        config: the sensor; its size and its refractory period are replaced.
        chip_lux: light before the step, on the chip [lux].
        on: whether the steps go up.
        seed: of the sensor.
    """
    coarse = np.geomspace(0.01, _GREATEST_CONTRAST, WIDTH - CONTROLS)
    found = fit_s_curve(
        coarse, *response(config, coarse, chip_lux=chip_lux, on=on, seed=seed, height=HEIGHT // 3)
    )
    if found.threshold is None:
        return found
    greatest = min(2.5 * found.threshold, _GREATEST_CONTRAST)
    fine = np.linspace(0.1 * found.threshold, greatest, WIDTH - CONTROLS)
    return fit_s_curve(
        fine, *response(config, fine, chip_lux=chip_lux, on=on, seed=seed, height=HEIGHT)
    )


def response(
    config: SensorConfig,
    contrast: Contrasts,
    *,
    chip_lux: float,
    on: bool,
    seed: int,
    height: int,
) -> tuple[Contrasts, float]:
    """Share of pixels that respond to a step.

    Args:
        config: the sensor; its size and its refractory period are replaced.
        contrast: (n,) sizes of the steps, each seen by one column [ln units].
        chip_lux: light before the step, on the chip [lux].
        on: whether the steps go up.
        seed: of the sensor.
        height: pixels that see each step.

    Returns:
        (n,) shares, and the share of the control columns, which saw none.
    """
    tau_us = time_constant_us(config, chip_lux)
    hold_us = min(math.ceil(_SETTLING * tau_us), 1_000_000)
    sensor = resized(config, width=contrast.size + CONTROLS, height=height)
    sensor = replace(sensor, refractory_us=max(hold_us, config.refractory_us))
    steps = np.concatenate((contrast, np.zeros(CONTROLS)))
    base = chip_luminance(config, chip_lux)
    after = columns(sensor, base * np.exp(steps if on else -steps))
    step_us = 1000 + sensor.refractory_us + math.ceil(_READY * tau_us) + 20
    end_us = step_us + math.ceil(_WINDOW * tau_us) + 20
    samples = _step_samples(uniform(sensor, base), after, step_us=step_us, end_us=end_us)
    recording = record(sensor, samples, seed=seed)
    late = between(recording.events, step_us, end_us)
    fired = counts(late[late["p"] == on], recording.shape) > 0
    share = fired.mean(axis=0)
    return share[: contrast.size], float(share[contrast.size :].mean())


def fit_s_curve(contrast: Contrasts, probability: Contrasts, guess: float) -> SCurve:
    """Fit θ, σ and l to an S-curve whose share of noise is known."""
    nothing = SCurve(contrast, probability, None, None, guess, 1.0 - guess)
    top = float(np.sort(probability)[-5:].mean())
    if top - guess < _LEAST_RESPONSE * (1.0 - guess):
        return nothing
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
    """Dark current from apparent ON thresholds against light; None from fewer than three of them.

    Args:
        chip_lux: (n,) light on the chip [lux].
        threshold: (n,) apparent thresholds [ln units], NaN where there is none.

    Returns:
        Illuminance on the chip that makes as much current as there is in the dark [lux].
    """
    lux, theta = np.asarray(chip_lux, np.float64), np.asarray(threshold, np.float64)
    known = np.isfinite(theta)
    if np.count_nonzero(known) < 3:
        return None
    slope, hidden = np.polyfit(1.0 / lux[known], np.expm1(theta[known]), 1)
    return max(0.0, float(slope / hidden))


def measure(config: SensorConfig, *, seed: int) -> Section:
    """The S-curves of the data sheet."""
    scale = chip_lux_per_scene_lux(config)
    curves = {
        on: [measure_s_curve(config, chip_lux=lux * scale, on=on, seed=seed) for lux in SCENE_LUX]
        for on in (True, False)
    }
    return Section(
        "Contrast threshold (S-curves)",
        "Steps of light of every size on a grey card of 18 %, each seen by 400 pixels that were "
        "reset just before; the share of pixels that answer in the step's polarity. Threshold "
        "and mismatch are the mean and the standard deviation of the normal distribution fitted "
        "to the curve, with the share that noise makes fire measured on pixels without a step. "
        "In dim light the dark current hides part of each step, so that the apparent threshold "
        "grows; from how it grows the dark current is found.",
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
            Quantity(f"{name} threshold at 1 klux", "ln units", theta, nominal),
            Quantity(f"{name} mismatch at 1 klux", "%", percent, sources.MISMATCH),
            Quantity("the same", "%", percent, sources.MISMATCH_DVS128),
        ]
    thetas = of_light([c.threshold if c.guess < _NOISY else None for c in curves[True]])
    dark = fit_dark_lux(np.array(SCENE_LUX) * scale, thetas)
    quantities.append(Quantity("dark current as light on the chip", "lux", dark, sources.DARK_LUX))
    return quantities


def _curve_plot(curves: list[SCurve], on: bool) -> Plot:
    lines = []
    for tint, (lux, curve) in enumerate(zip(SCENE_LUX, curves, strict=True)):
        lines.append(
            series(light_label(lux), curve.contrast, curve.probability, Style.POINTS, tint)
        )
        if curve.threshold is not None and curve.mismatch is not None:
            c = np.geomspace(float(curve.contrast[0]), float(curve.contrast[-1]), 200)
            share = ndtr((c - curve.threshold) / curve.mismatch)
            fitted = curve.guess + (1.0 - curve.guess - curve.lapse) * share
            lines.append(series("", c, fitted, Style.LINE, tint))
    name = "ON" if on else "OFF"
    return Plot(
        f"{name} events against the size of a step",
        "step [ln units of light]",
        "share of pixels that fire",
        lines,
        x_log=True,
    )


def _threshold_plot(curves: dict[bool, list[SCurve]]) -> Plot:
    at, nominal = REFERENCE_LUX, [sources.THETA_ON.value, sources.THETA_OFF.value]
    lines = [
        series(name, SCENE_LUX, of_light([c.threshold for c in curves[on]]), Style.LINE, tint)
        for tint, (on, name) in enumerate(((True, "ON"), (False, "OFF")))
    ]
    lines.append(series("maker's biases", [at, at], nominal, Style.PUBLISHED))
    return Plot(
        "Apparent threshold against light",
        "light on the scene [lux]",
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
