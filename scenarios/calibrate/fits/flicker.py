"""Flicker of lamps on the mains: frequency and depth.

A lamp that flickers gives each pixel ON events once in each period and OFF events half a period
later. The difference of ON and OFF events over time therefore has a line in its spectrum. Pixels
whose ON events have the same phase in each period see the lamp (Rayleigh's test of direction). The
depth follows from the ON events of a period, each of which is a rise by θ_on.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator.characterisation import Plot, Quantity, Section, Style
from emulator.characterisation.section import series
from flybench.events import Events
from scenarios.calibrate.fit import Fit
from scenarios.calibrate.recording import CalibrationRecording, PixelEvents

_BIN_US = 500
_LOWEST_HZ, _HIGHEST_HZ = 40.0, 400.0
"""Range of frequencies (assumed: mains lamps flicker at 100 or 120 Hz, and some at 50 or 60)."""
_FEWEST_PERIODS = 5
_LEAST_SHARE = 0.2
"""Least share of the spectrum in the line and its harmonics (assumed)."""
_PADDING = 16
_LEAST_ORDER = 0.7
"""Least mean resultant length of a pixel's ON events (assumed)."""
_FEWEST_EVENTS = 5

F64 = npt.NDArray[np.float64]


class Flicker(NamedTuple):
    """Flicker of a recording.

    Attributes:
        hz: frequency [Hz].
        error_hz: standard error [Hz].
        share: share of the spectrum in the line and its harmonics.
        pixels: number of pixels that see it.
        depth: (maximum − minimum)/(maximum + minimum) of the light, median over these pixels; None
            without pixels.
    """

    hz: float
    error_hz: float
    share: float
    pixels: int
    depth: float | None


def spectrum(events: Events) -> tuple[F64, F64]:
    """Return frequencies [Hz] and power of the difference of ON and OFF events."""
    t = events["t"] - events["t"][0]
    bins = int(t[-1]) // _BIN_US + 1
    signs = np.where(events["p"], 1.0, -1.0)
    signal = np.bincount(t // _BIN_US, signs, minlength=bins)
    signal = (signal - signal.mean()) * np.hanning(bins)
    size = _PADDING * bins
    power = np.abs(np.fft.rfft(signal, size)) ** 2
    return np.asarray(np.fft.rfftfreq(size, _BIN_US * 1e-6), np.float64), power


def find_flicker(
    recording: CalibrationRecording, events: PixelEvents, theta_on: float
) -> Flicker | None:
    """Find flicker; None if the recording is too short or has none.

    Args:
        recording: the recording.
        events: its events by pixel.
        theta_on: ON threshold [ln units].
    """
    duration_s = recording.duration_s
    if duration_s * _LOWEST_HZ < _FEWEST_PERIODS:
        return None
    hz, power = spectrum(recording.events)
    inside = (hz >= _LOWEST_HZ) & (hz <= _HIGHEST_HZ)
    k = int(np.flatnonzero(inside)[power[inside].argmax()])
    peak_hz = _refined(hz, power, k)
    width = 2.0 / duration_s
    high = hz >= _LOWEST_HZ - width
    near = np.abs(hz - peak_hz * np.maximum(np.rint(hz / peak_hz), 1.0)) <= width
    share = float(power[near & high].sum() / max(power[high].sum(), 1e-300))
    pixels, rises = _flickering(events, peak_hz, duration_s)
    if share < _LEAST_SHARE or pixels == 0:
        return None
    swing = theta_on * float(np.median(rises))
    ons = int(np.count_nonzero(events.on))
    error = math.sqrt(6.0) / (math.pi * duration_s * math.sqrt(max(ons * share, 1.0)))
    return Flicker(peak_hz, error, share, pixels, math.tanh(swing / 2.0))


def _refined(hz: F64, power: F64, k: int) -> float:
    """Return the frequency of a peak, from the parabola through its three values."""
    before, peak, after = power[k - 1 : k + 2]
    bend = before - 2.0 * peak + after
    shift = 0.5 * (before - after) / bend if bend else 0.0
    return float(hz[k] + shift * (hz[1] - hz[0]))


def _flickering(events: PixelEvents, hz: float, duration_s: float) -> tuple[int, F64]:
    """Return the number of pixels that see the flicker, and their ON events a period."""
    on, size = events.on, events.offsets.size - 1
    phase = np.exp(2j * np.pi * hz * 1e-6 * events.t[on])
    count = np.bincount(events.pixel[on], minlength=size)
    total = np.bincount(events.pixel[on], phase.real, minlength=size) + 1j * np.bincount(
        events.pixel[on], phase.imag, minlength=size
    )
    periods = hz * duration_s
    enough = count >= max(_FEWEST_EVENTS, 0.5 * periods)
    seen = enough & (np.abs(total) >= _LEAST_ORDER * np.maximum(count, 1))
    return int(seen.sum()), count[seen] / periods


def flicker_page(
    recording: CalibrationRecording, events: PixelEvents, theta_on: float
) -> tuple[Fit, Flicker | None]:
    """Return frequency and depth of the flicker, and the spectrum."""
    method = (
        "The spectrum of ON minus OFF events of the whole array. Flicker is reported if a line and "
        f"its harmonics hold {100 * _LEAST_SHARE:.0f} % of it. A pixel sees the lamp if its ON "
        "events come at the same phase of each period. The depth is that of light whose logarithm "
        "rises by θ_on with each of them; photoreceptor and refractory period make it look smaller."
    )
    found = find_flicker(recording, events, theta_on)
    rows: list[Quantity] = []
    if found is None:
        rows.append(Quantity("frequency", "Hz", None, note="no lamp flickers visibly"))
    else:
        note = f"± {1.96 * found.error_hz:.2g} Hz (95 %)"
        rows = [
            Quantity("frequency", "Hz", found.hz, note=note),
            Quantity("depth", "", found.depth, note="median over the pixels that see it"),
            Quantity("pixels that see it", "", float(found.pixels)),
            Quantity("share of the spectrum", "", found.share),
        ]
    plots = [_plot(recording)] if recording.duration_s * _LOWEST_HZ >= _FEWEST_PERIODS else []
    return Fit("flicker", (), Section("Flicker of lamps", method, rows, plots)), found


def _plot(recording: CalibrationRecording) -> Plot:
    hz, power = spectrum(recording.events)
    inside = (hz >= 5.0) & (hz <= _HIGHEST_HZ)
    hz, power = hz[inside], power[inside]
    step = max(1, hz.size // 800)
    kept = hz.size // step * step
    highest = power[:kept].reshape(-1, step).max(axis=1)
    relative = highest / max(float(highest.max(initial=0.0)), 1e-300)
    curve = series("ON − OFF", hz[:kept:step], relative, Style.LINE)
    return Plot("Spectrum of the events", "frequency [Hz]", "power, relative", [curve])
