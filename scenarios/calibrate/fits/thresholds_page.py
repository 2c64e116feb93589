"""The thresholds on the page: parameters, and the fit over its data."""

from __future__ import annotations

import numpy as np

from emulator import SensorConfig
from emulator.characterisation import Plot, Quantity, Section, Style
from emulator.characterisation.section import series
from scenarios.calibrate.fit import Fit, Parameter, unknown
from scenarios.calibrate.fits.thresholds import (
    FEWEST,
    LEAST_CHANGE,
    ThresholdFit,
    fit_mismatch,
)

_MOST_HALF_WIDTH = 0.15
"""Widest half of the interval, as a share of the threshold, that counts as told (assumed)."""


def thresholds_page(fit: ThresholdFit | None, sensor: SensorConfig) -> Fit:
    """Return parameters and figures of the thresholds."""
    method = (
        "From one frame to the next, the logarithm of a pixel's light changes by θ_on for every ON "
        "event and by −θ_off for every OFF event (Wang et al., ACRA 2019). Frames are predicted "
        "from the events with their blur (Pan et al., CVPR 2019), and compared where the light "
        f"changes by {LEAST_CHANGE:g} ln units or more. The changes of the frames are the "
        "instruments of the fit. Events on steep edges count for more, as the refractory period of "
        f"{sensor.refractory_us} µs makes them, and events helped by noise (σ0 = "
        f"{sensor.noise_sigma:.3g}) for less."
    )
    title = "Contrast thresholds"
    names = ("theta_on", "theta_off", "theta_mismatch")
    if fit is None:
        reason = f"fewer than {FEWEST} pixels change by {LEAST_CHANGE:g} ln units between frames"
        missing = tuple(unknown(name, "ln units", reason) for name in names)
        return Fit("thresholds", missing, Section(title, method, ()))
    parameters = [
        _threshold(name, value, error, number)
        for name, value, error, number in zip(
            names, (fit.theta_on, fit.theta_off), fit.errors, fit.counts, strict=False
        )
    ]
    mismatch, pixels = fit_mismatch(fit), len(fit.spread)
    if mismatch is None:
        reason = "too few pixels have enough events"
        parameters.append(unknown("theta_mismatch", "ln units", reason))
    else:
        evidence = f"from {pixels:,} pixels over the whole recording"
        parameters.append(Parameter("theta_mismatch", "ln units", mismatch, None, evidence))
    share = Quantity("mean rest, of the threshold", "%", 100.0 * fit.share)
    plots = [_change_plot(fit), _mismatch_plot(fit, mismatch)]
    return Fit("thresholds", tuple(parameters), Section(title, method, (share,), plots))


def _threshold(name: str, value: float, error: float, number: int) -> Parameter:
    half = 1.96 * float(error)
    if half > _MOST_HALF_WIDTH * value:
        reason = f"{value:.3g} ± {half:.2g} from {number:,} changes is too uncertain"
        return unknown(name, "ln units", reason)
    interval = value - half, value + half
    return Parameter(name, "ln units", value, interval, f"from {number:,} changes between frames")


def _change_plot(fit: ThresholdFit) -> Plot:
    """Plot the change that the events predict against that of the frames, in classes of it."""
    edges = np.linspace(-2.5, 2.5, 41)
    index = np.digitize(fit.measured, edges)
    centres, rows = [], []
    for k in np.unique(index):
        inside = fit.predicted[index == k]
        if inside.size >= 20 and 0 < k < edges.size:
            centres.append(float(np.median(fit.measured[index == k])))
            rows.append(np.percentile(inside, [10, 50, 90]))
    low, middle, high = np.array(rows).T if rows else np.empty((3, 0))
    return Plot(
        "Change from frame to frame",
        "frames [ln units]",
        "predicted from events [ln units]",
        [
            series("median", centres, middle),
            series("10 %", centres, low, Style.LINE, 1),
            series("90 %", centres, high, Style.LINE, 1),
            series("equal", edges, edges, Style.GUIDE),
        ],
    )


def _mismatch_plot(fit: ThresholdFit, mismatch: float | None) -> Plot:
    events, residual = fit.spread[:, 1], np.abs(fit.spread[:, 0])
    edges = np.unique(np.geomspace(1.0, max(float(events.max(initial=2.0)), 2.0), 16))
    index = np.digitize(events, edges)
    kept = [k for k in np.unique(index) if np.count_nonzero(index == k) >= 20]
    x = [float(np.median(events[index == k])) for k in kept]
    y = [1.4826 * float(np.median(residual[index == k])) for k in kept]
    curves = [series("pixels", x, y)]
    if mismatch is not None:
        rest = 1.4826 * float(np.median(np.abs(fit.measured - fit.predicted)))
        curves.append(series("fit", edges, np.hypot(rest, mismatch * edges), Style.LINE))
    return Plot(
        "Mismatch of the thresholds",
        "events of a pixel, √(ON² + OFF²)",
        "standard deviation of the residual [ln units]",
        curves,
        x_log=True,
        y_log=True,
    )
