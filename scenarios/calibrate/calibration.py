"""All fits of a recording, in an order in which each uses the results of those before."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from emulator import SensorConfig
from scenarios.calibrate.fit import Fit, Parameter
from scenarios.calibrate.fits.flicker import Flicker, flicker_page
from scenarios.calibrate.fits.leak_spread import fit_leak_spread, hot_pixels, leak_page
from scenarios.calibrate.fits.noise import fit_noise
from scenarios.calibrate.fits.noise_page import noise_page
from scenarios.calibrate.fits.quiet_time import quiet_time
from scenarios.calibrate.fits.readout import readout_page
from scenarios.calibrate.fits.refractory import refractory_page
from scenarios.calibrate.fits.thresholds import fit_thresholds
from scenarios.calibrate.fits.thresholds_page import thresholds_page
from scenarios.calibrate.recording import CalibrationRecording, events_by_pixel

_ROUNDS = 2
"""Rounds of thresholds and noise, each of which needs the other."""
STEPS = 3 + 2 * _ROUNDS
"""Number of calls of `progress`."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """Results of all fits.

    Attributes:
        sensor: the sensor with all values that the recording tells, and those of the start else.
        fits: all fits, in the order of the page.
        flicker: flicker of lamps; None if there is none.
    """

    sensor: SensorConfig
    fits: tuple[Fit, ...]
    flicker: Flicker | None

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of all fits."""
        return tuple(parameter for fit in self.fits for parameter in fit.parameters)


def calibrate(
    recording: CalibrationRecording,
    start: SensorConfig,
    progress: Callable[[int, int], None] = lambda _done, _all: None,
) -> Calibration:
    """Estimate the parameters of a sensor from a recording.

    Args:
        recording: events and frames.
        start: sensor whose values are kept where the recording tells nothing.
        progress: called with the number of fits done and the number of all.
    """
    events = events_by_pixel(recording.events, recording.shape)
    refractory = refractory_page(events)
    rows, columns = recording.shape
    start = replace(start, width=columns, height=rows)
    sensor = with_values(start, refractory)
    progress(1, STEPS)
    quiet = quiet_time(recording)
    usual = quiet.of(~hot_pixels(quiet))
    progress(2, STEPS)
    for number in range(_ROUNDS):
        found = fit_thresholds(recording, events, sensor)
        thresholds = thresholds_page(found, sensor)
        told = with_values(with_values(start, refractory), thresholds)
        progress(3 + 2 * number, STEPS)
        noise = noise_page(fit_noise(usual, told, cutoff=number > 0))
        sensor = with_values(told, noise)
        progress(4 + 2 * number, STEPS)
    leak = leak_page(fit_leak_spread(usual, sensor), quiet, sensor)
    sensor = with_values(sensor, leak)
    flicker, lamp = flicker_page(recording, events, sensor.theta_on)
    fits = (thresholds, refractory, noise, leak, flicker, readout_page(recording.events))
    progress(STEPS, STEPS)
    return Calibration(sensor, fits, lamp)


def with_values(sensor: SensorConfig, fit: Fit) -> SensorConfig:
    """Return a sensor with the values that a fit tells."""
    values: Mapping[str, Any] = {
        parameter.name: parameter.value
        for parameter in fit.parameters
        if parameter.value is not None and "." not in parameter.name
    }
    return replace(sensor, **values)
