"""Events per cycle against the frequency of a flickering light: the bandwidth, per decade of light.

The logarithm of the light is a sine of peak-to-peak P (Lichtsteiner 2008 shows the bandwidth so).
How many events a cycle of an amplitude makes, N_0(P), is measured at a low frequency in bright
light, with all amplitudes side by side. At frequency f the photoreceptor damps the amplitude, and
each event costs what the signal does in the refractory period T, on average (π²/4)·f·P·T/θ of an
event (the mean slope of a sine, weighted by its own events). So the number against frequency is
fitted with

    N(f) = N_0(P·g)/(1 + (π²/4)·f·(P·g/θ)·T),    g = s/√(1 + (f/f_c)²)

with the cutoff f_c, and the share s of the amplitude that the dark current leaves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    SCENE_LUX,
    chip_luminance,
    chip_lux_per_scene_lux,
    counts,
    decades,
    light_label,
    of_light,
    record,
    resized,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from flybench.events import Cause

WIDTH = 96
LEAST_SWING, _SWING_IN_THRESHOLDS, _GREATEST_SWING = 1.0, 5.5, 8.0
"""Of the flicker, peak to peak [ln units of light]: 2.7 to 1, or more where that would make fewer
than five events a cycle."""
_MARGIN = 1.2
"""Amplitudes calibrated, over the flicker's: the fit may try a share above 1."""
_CALIBRATION_LUX = 2000.0
"""On the chip: bright enough for the full bandwidth and hardly any noise."""
_CALIBRATION_HZ = 20.0
"""Two decades below the cutoff there."""
_CALIBRATION_ROWS = 160
"""Pixels of each amplitude: mismatch moves their mean by 1.5 %."""
_SAMPLES = 48
"""A cycle: straight lines between them stay within 0.2 % of the sine."""
_SETTLING_CYCLES, _CYCLES = 3, 4
"""Cycles passed over, in which the answer becomes the same each time, and cycles counted."""
_LEAST_EVENTS = 2.0
"""Events a cycle at the plateau below which no cutoff is fitted."""
_NOISY = 0.3
"""ON events of noise a cycle and pixel above which a frequency is not fitted."""
_REFERENCE_LUX = 1e3

Values = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Answer to flicker at one light.

    Attributes:
        frequency_hz: (n,) of the flicker [Hz].
        events_per_cycle: (n,) ON events of a pixel that the signal caused.
        noise_per_cycle: (n,) ON events of a pixel that noise caused.
        fit: share s and cutoff f_c [Hz], None where none was found among the frequencies.
    """

    frequency_hz: Values
    events_per_cycle: Values
    noise_per_cycle: Values
    fit: tuple[float, float] | None

    @property
    def cutoff_hz(self) -> float | None:
        """Fitted f_c [Hz]."""
        return None if self.fit is None else self.fit[1]


def measure_response(
    config: SensorConfig,
    calibration: Calibration,
    *,
    chip_lux: npt.ArrayLike,
    frequency_hz: Values,
    seed: int,
) -> list[FrequencyResponse]:
    """Responses to flicker at several lights, which rows of pixels see side by side.

    Args:
        config: the sensor; its size is replaced.
        calibration: of the same sensor.
        chip_lux: (m,) geometric means of the light on the chip, one a row [lux].
        frequency_hz: (n,) frequencies [Hz].
        seed: of the sensor.

    Returns:
        One response a light.
    """
    lux = np.atleast_1d(np.asarray(chip_lux, np.float64))
    amplitude = np.full((1, WIDTH), calibration.swing)
    found = [_events_per_cycle(config, lux, amplitude, float(f), seed) for f in frequency_hz]
    signal, noise = (
        np.array([part.mean(axis=1) for part in parts]).T for parts in zip(*found, strict=True)
    )
    responses = []
    for per_cycle, by_noise in zip(signal, noise, strict=True):
        fit = calibration.fit(frequency_hz, per_cycle, by_noise < _NOISY)
        responses.append(FrequencyResponse(frequency_hz, per_cycle, by_noise, fit))
    return responses


@dataclass(frozen=True, eq=False)
class Calibration:
    """Events a cycle against amplitude, N_0(P).

    Attributes:
        amplitude: (n,) peak to peak, rising from 0 [ln units].
        events: (n,) ON events a cycle and pixel.
        refractory_us: refractory period that the biases set [µs].
    """

    amplitude: Values
    events: Values
    refractory_us: float

    @property
    def swing(self) -> float:
        """Peak to peak of the flicker that it is for [ln units]."""
        return float(self.amplitude[-1]) / _MARGIN

    def model(self, frequency_hz: Values, share: float, cutoff_hz: float) -> Values:
        """(n,) events a cycle at `frequency_hz` of a pixel with that cutoff."""
        gain = share / np.sqrt(1.0 + (frequency_hz / cutoff_hz) ** 2)
        swing = self.swing * gain
        per_event = self.amplitude[-1] / (self.events[-1] + 1.0)
        lost = 0.25 * math.pi**2 * frequency_hz * swing * self.refractory_us * 1e-6 / per_event
        slow = np.interp(swing, self.amplitude, self.events)
        return np.asarray(slow / (1.0 + lost), np.float64)

    def fit(
        self, frequency_hz: Values, events_per_cycle: Values, trusted: npt.NDArray[np.bool_]
    ) -> tuple[float, float] | None:
        """Fit s and f_c to a response.

        Args:
            frequency_hz: (n,) frequencies [Hz].
            events_per_cycle: (n,) ON events a cycle and pixel.
            trusted: (n,) which of them to fit.

        Returns:
            s and f_c [Hz], None where the pixel hardly follows, or up to all frequencies.
        """
        if np.count_nonzero(trusted) < 4 or events_per_cycle[trusted].max() < _LEAST_EVENTS:
            return None
        high = trusted & (events_per_cycle >= 0.5 * events_per_cycle[trusted].max())
        start = np.array([1.0, math.log(frequency_hz[high][-1])])

        def residual(p: Values) -> Values:
            model = self.model(frequency_hz, p[0], math.exp(p[1]))
            return np.asarray((model - events_per_cycle)[trusted], np.float64)

        share, log_cutoff = least_squares(residual, start, diff_step=1e-3).x
        cutoff_hz = math.exp(log_cutoff)
        within = frequency_hz[0] < cutoff_hz < frequency_hz[-1]
        return (float(share), cutoff_hz) if within else None


def calibrate(config: SensorConfig, *, seed: int) -> Calibration:
    """Events a cycle against amplitude, slowly and in bright light."""
    swing = min(max(LEAST_SWING, _SWING_IN_THRESHOLDS * config.theta_on), _GREATEST_SWING)
    amplitude = np.linspace(0.0, _MARGIN * swing, WIDTH)[None, :]
    lux = np.full(_CALIBRATION_ROWS, _CALIBRATION_LUX)
    events, _ = _events_per_cycle(config, lux, amplitude, _CALIBRATION_HZ, seed)
    rising = np.maximum.accumulate(events.mean(axis=0))
    return Calibration(amplitude[0], rising, config.refractory_us)


def measure(config: SensorConfig, *, seed: int) -> Section:
    """The frequency response of the data sheet."""
    frequency_hz = decades(0.3, 2e4, 4)
    lux = np.array(SCENE_LUX) * chip_lux_per_scene_lux(config)
    calibration = calibrate(config, seed=seed)
    responses = measure_response(
        config, calibration, chip_lux=lux, frequency_hz=frequency_hz, seed=seed
    )
    cutoffs = of_light([response.cutoff_hz for response in responses])
    at = SCENE_LUX.index(_REFERENCE_LUX)
    return Section(
        "Bandwidth",
        f"A grey card of 18 % flickers by {math.exp(calibration.swing):.1f} to 1, sinusoidally in "
        "the logarithm; ON events of the signal per cycle and pixel. The cutoff is that of the "
        "first-order low-pass fitted to the curve, by way of the events that slow flicker of "
        "lesser amplitude makes. Where the card makes fewer than "
        f"{_LEAST_EVENTS:g} events a cycle there is none: in dim light the dark current hides the "
        "flicker, and noise resets the pixels before they cross their thresholds.",
        [
            Quantity(
                "cutoff at 1 klux on the scene",
                "Hz",
                responses[at].cutoff_hz,
                sources.BANDWIDTH_HZ,
                "behind this lens; the light on the published sensor's chip is not known",
            ),
            Quantity("cutoff at 100 klux on the scene", "Hz", responses[-1].cutoff_hz),
        ],
        [_response_plot(responses, calibration), _cutoff_plot(cutoffs)],
    )


def _events_per_cycle(
    config: SensorConfig, lux: Values, amplitude: Values, frequency_hz: float, seed: int
) -> tuple[Values, Values]:
    """ON events a cycle by signal and by noise, each (lights, WIDTH).

    Args:
        config: the sensor; its size is replaced.
        lux: (lights,) on the chip, one a row [lux].
        amplitude: (1, WIDTH) of each column, peak to peak [ln units].
        frequency_hz: of the flicker [Hz].
        seed: of the sensor.
    """
    sensor = resized(config, width=WIDTH, height=lux.size)
    base = np.repeat(chip_luminance(sensor, lux)[:, None], WIDTH, axis=1)
    period_us = 1e6 / frequency_hz
    number = min(_SAMPLES, max(8, math.floor(period_us)))
    cycles = _SETTLING_CYCLES + _CYCLES
    times = np.unique(np.rint(np.arange(cycles * number + 1) * period_us / number).astype(int))
    sines = 0.5 * np.sin(2.0 * math.pi * times / period_us)
    samples = (
        (int(t), (base * np.exp(s * amplitude)).astype(np.float32))
        for t, s in zip(times, sines, strict=True)
    )
    recording = record(sensor, samples, seed=seed)
    events = recording.events
    counted = (events["t"] > _SETTLING_CYCLES * period_us) & events["p"]
    signal = counted & (recording.causes == Cause.SIGNAL)
    by_signal = counts(events[signal], recording.shape) / _CYCLES
    return by_signal, counts(events[counted], recording.shape) / _CYCLES - by_signal


def _response_plot(responses: list[FrequencyResponse], calibration: Calibration) -> Plot:
    lines = []
    for tint, (lux, response) in enumerate(zip(SCENE_LUX, responses, strict=True)):
        frequency = response.frequency_hz
        points = response.events_per_cycle
        lines.append(series(light_label(lux), frequency, points, Style.POINTS, tint))
        if response.fit is not None:
            x = np.geomspace(frequency[0], frequency[-1], 200)
            lines.append(series("", x, calibration.model(x, *response.fit), Style.LINE, tint))
    return Plot(
        "ON events per cycle",
        "frequency of the flicker [Hz]",
        "events per cycle and pixel",
        lines,
        x_log=True,
    )


def _cutoff_plot(cutoffs: list[float]) -> Plot:
    published = sources.BANDWIDTH_HZ
    return Plot(
        "Cutoff against light",
        "light on the scene [lux]",
        "cutoff [Hz]",
        [
            series("measured", SCENE_LUX, cutoffs, Style.LINE, 0),
            series("Lichtsteiner 2008", [1e3], [published.value], Style.PUBLISHED),
        ],
        x_log=True,
        y_log=True,
    )
