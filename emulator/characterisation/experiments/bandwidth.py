"""Bandwidth: events per cycle against the frequency of flicker, for each decade of illuminance.

The logarithm of the luminance is a sine of peak-to-peak amplitude P (Lichtsteiner 2008 shows the
bandwidth in this way). The number of events in a cycle of that amplitude, N_0(P), is measured at a
low frequency in bright light, with all amplitudes side by side. At frequency f the photoreceptor
damps the amplitude. The refractory period is set short: otherwise it would limit the events of fast
flicker, not the bandwidth. Each event also costs the change of the signal in the refractory period
T, on average (π²/4)·f·P·T/θ of an event (the mean slope of a sine, weighted by its own events). So
the number against frequency is fitted with

    N(f) = N_0(P·g)/(1 + (π²/4)·f·(P·g/θ)·T),    g = s/√(1 + (f/f_c)²)

with the cutoff f_c, and the share s of the amplitude that the dark current leaves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    SCENE_LUX,
    bench_sensor,
    chip_luminance,
    chip_lux_per_scene_lux,
    event_counts,
    log_spaced,
    lux_label,
    nan_for_none,
    record,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from flybench.events import Cause

WIDTH = 96
"""Columns of the array, one for each amplitude of the calibration."""
LEAST_SWING, _SWING_IN_THRESHOLDS, _GREATEST_SWING = 1.0, 5.5, 8.0
"""Peak-to-peak amplitude of the flicker: at least 1 ln unit (2.7 to 1), more if that would cause
fewer than five events per cycle, at most 8 [ln units of luminance]."""
_MARGIN = 1.2
"""Highest calibrated amplitude over that of the flicker, since the fit may try a share above 1."""
_CALIBRATION_LUX = 2000.0
"""Illuminance on the chip: bright enough for the full bandwidth and hardly any noise [lux]."""
_CALIBRATION_HZ = 20.0
"""Flicker two decades below the cutoff at that illuminance [Hz]."""
_CALIBRATION_ROWS = 160
"""Pixels for each amplitude: mismatch moves their mean by 1.5 %."""
_REFRACTORY_US = 3
"""Longest refractory period of the sensors of this experiment [µs]."""
_SAMPLES = 48
"""Samples per cycle: straight lines between them stay within 0.2 % of the sine."""
_SETTLING_CYCLES, _CYCLES = 3, 4
"""Cycles skipped until the response is periodic, and cycles counted."""
_LEAST_EVENTS = 2.0
"""Events per cycle at the plateau below which no cutoff is fitted."""
_NOISY = 0.3
"""ON events by noise per cycle and pixel above which a frequency is left out of the fit."""
_REFERENCE_LUX = 1e3
"""Illuminance on the scene at which the published cutoff is given [lux]."""

Values = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Response to flicker at one illuminance.

    Attributes:
        frequency_hz: (n,) frequency of the flicker [Hz].
        events_per_cycle: (n,) ON events of a pixel per cycle that the signal caused.
        noise_per_cycle: (n,) ON events of a pixel per cycle that noise caused.
        fit: share s and cutoff f_c [Hz]; None if there is no cutoff within the frequencies.
    """

    frequency_hz: Values
    events_per_cycle: Values
    noise_per_cycle: Values
    fit: tuple[float, float] | None

    @property
    def cutoff_hz(self) -> float | None:
        """Fitted cutoff f_c [Hz]; None if there is none."""
        return None if self.fit is None else self.fit[1]


def measure_response(
    config: SensorConfig,
    calibration: Calibration,
    *,
    chip_lux: npt.ArrayLike,
    frequency_hz: Values,
    seed: int,
) -> list[FrequencyResponse]:
    """Measure the response to flicker at several illuminances, one for each row of pixels.

    Args:
        config: configuration of the sensor; its size and refractory period are replaced.
        calibration: calibration of the same sensor.
        chip_lux: (m,) geometric mean of the illuminance on the chip, one for each row [lux].
        frequency_hz: (n,) frequencies [Hz].
        seed: seed of the sensor.

    Returns:
        One response for each illuminance.
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
    """Events per cycle against amplitude, N_0(P).

    Attributes:
        amplitude: (n,) peak-to-peak amplitudes, rising from 0 [ln units].
        events: (n,) ON events per cycle and pixel.
        refractory_us: refractory period of the sensor in this experiment [µs].
    """

    amplitude: Values
    events: Values
    refractory_us: float

    @property
    def swing(self) -> float:
        """Peak-to-peak amplitude of the flicker that this calibration serves [ln units]."""
        return float(self.amplitude[-1]) / _MARGIN

    def model(self, frequency_hz: Values, share: float, cutoff_hz: float) -> Values:
        """Return the events per cycle of a pixel with that share and cutoff, (n,)."""
        gain = share / np.sqrt(1.0 + (frequency_hz / cutoff_hz) ** 2)
        swing = self.swing * gain
        per_event = self.amplitude[-1] / (self.events[-1] + 1.0)
        lost = 0.25 * math.pi**2 * frequency_hz * swing * self.refractory_us * 1e-6 / per_event
        slow = np.interp(swing, self.amplitude, self.events)
        return np.asarray(slow / (1.0 + lost), np.float64)

    def fit(
        self, frequency_hz: Values, events_per_cycle: Values, trusted: npt.NDArray[np.bool_]
    ) -> tuple[float, float] | None:
        """Fit share s and cutoff f_c to a response.

        Args:
            frequency_hz: (n,) frequencies [Hz].
            events_per_cycle: (n,) ON events per cycle and pixel.
            trusted: (n,) True for the frequencies to fit.

        Returns:
            s and f_c [Hz]; None if the pixel hardly follows the flicker, or follows all
            frequencies.
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
    """Measure events per cycle against amplitude, with slow flicker in bright light."""
    swing = min(max(LEAST_SWING, _SWING_IN_THRESHOLDS * config.theta_on), _GREATEST_SWING)
    amplitude = np.linspace(0.0, _MARGIN * swing, WIDTH)[None, :]
    lux = np.full(_CALIBRATION_ROWS, _CALIBRATION_LUX)
    events, _ = _events_per_cycle(config, lux, amplitude, _CALIBRATION_HZ, seed)
    rising = np.maximum.accumulate(events.mean(axis=0))
    return Calibration(amplitude[0], rising, _short_reset(config).refractory_us)


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on bandwidth."""
    frequency_hz = log_spaced(0.3, 2e4, 4)
    lux = np.array(SCENE_LUX) * chip_lux_per_scene_lux(config)
    calibration = calibrate(config, seed=seed)
    responses = measure_response(
        config, calibration, chip_lux=lux, frequency_hz=frequency_hz, seed=seed
    )
    cutoffs = nan_for_none([response.cutoff_hz for response in responses])
    at = SCENE_LUX.index(_REFERENCE_LUX)
    return Section(
        "Bandwidth",
        f"A grey card of 18 % reflectance flickers by {math.exp(calibration.swing):.1f} to 1, as a "
        "sine in the logarithm. The refractory period is set short. The curves show the ON events "
        "that the signal causes, per cycle and pixel. The cutoff is that of a first-order low-pass "
        "fitted to each curve. The fit relates amplitude to events with a calibration by slow "
        "flicker of smaller amplitudes. "
        f"There is no cutoff where the card causes fewer than {_LEAST_EVENTS:g} events per cycle: "
        "in dim light the dark current hides the flicker, and noise resets the pixels before they "
        "cross their thresholds.",
        [
            Quantity(
                "cutoff at 1 klux on the scene",
                "Hz",
                responses[at].cutoff_hz,
                sources.BANDWIDTH_HZ,
                "behind this lens; the illuminance on the chip of the published sensor is unknown",
            ),
            Quantity(
                "cutoff at 100 klux on the scene",
                "Hz",
                responses[-1].cutoff_hz,
                sources.FOLLOWER_HZ,
                "of photoreceptor and source follower in a row; the slower limits it",
            ),
        ],
        [_response_plot(responses, calibration), _cutoff_plot(cutoffs)],
    )


def _events_per_cycle(
    config: SensorConfig, lux: Values, amplitude: Values, frequency_hz: float, seed: int
) -> tuple[Values, Values]:
    """Count ON events per cycle by signal and by noise, each (rows, WIDTH).

    Args:
        config: configuration of the sensor; its size and refractory period are replaced.
        lux: (rows,) illuminance on the chip of each row [lux].
        amplitude: (1, WIDTH) peak-to-peak amplitude of each column [ln units].
        frequency_hz: frequency of the flicker [Hz].
        seed: seed of the sensor.
    """
    sensor = bench_sensor(_short_reset(config), width=WIDTH, height=lux.size)
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
    by_signal = event_counts(events[signal], recording.shape) / _CYCLES
    return by_signal, event_counts(events[counted], recording.shape) / _CYCLES - by_signal


def _short_reset(config: SensorConfig) -> SensorConfig:
    return replace(config, refractory_us=min(config.refractory_us, _REFRACTORY_US))


def _response_plot(responses: list[FrequencyResponse], calibration: Calibration) -> Plot:
    lines = []
    for colour_index, (lux, response) in enumerate(zip(SCENE_LUX, responses, strict=True)):
        frequency = response.frequency_hz
        points = response.events_per_cycle
        lines.append(series(lux_label(lux), frequency, points, Style.POINTS, colour_index))
        if response.fit is not None:
            x = np.geomspace(frequency[0], frequency[-1], 200)
            lines.append(
                series("", x, calibration.model(x, *response.fit), Style.LINE, colour_index)
            )
    return Plot(
        "ON events per cycle",
        "frequency of the flicker [Hz]",
        "ON events per cycle and pixel",
        lines,
        x_log=True,
    )


def _cutoff_plot(cutoffs: list[float]) -> Plot:
    published = sources.BANDWIDTH_HZ
    return Plot(
        "Cutoff against illuminance",
        "illuminance on the scene [lux]",
        "cutoff [Hz]",
        [
            series("measured", SCENE_LUX, cutoffs, Style.LINE, 0),
            series("Lichtsteiner 2008", [1e3], [published.value], Style.PUBLISHED),
        ],
        x_log=True,
        y_log=True,
    )
