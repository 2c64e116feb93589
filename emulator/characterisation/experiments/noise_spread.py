"""Noise pixel by pixel: how much the pixels differ, and in which order their events come.

Means hide most of what tells a noise model apart. In a pixel that resets to what it sees, events
alternate, ON/OFF is the ratio of the thresholds of that pixel, and rates differ from pixel to pixel
by orders of magnitude.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import Recording, event_counts, lux_label
from emulator.characterisation.experiments.background import record_static
from emulator.characterisation.section import Plot, Published, Quantity, Section, Style, series
from emulator.config import SensorConfig

DIM_LUX, DARK_LUX = sources.JOUBERT_LUX[0], sources.CRADLE_LUX[0]
"""Illuminances on the chip of the published distributions [lux]."""
WINDOW_US = 511_000
"""Length of the clip in whose time most pixels are silent [µs]."""
_FEWEST_EVENTS = 5
"""Fewest events of each polarity of a pixel whose logarithms are counted."""
_FEWEST_PIXELS = 50
"""Fewest such pixels from which a deviation is given: it is then uncertain by 10 %."""
_QUANTILES = (5, 50, 95)

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PixelNoise:
    """Noise of the pixels of a static recording.

    Attributes:
        rates_hz: (2, pixels) rates of ON and OFF events [Hz].
        ln_rates: (2, n) logarithms of the rates of the pixels with five events of each polarity.
        variation: mean coefficient of variation of the intervals of a pixel, between ON events and
            between OFF events; None if the events are too few.
        alternating: share of the events of a pixel whose polarity differs from the one before; None
            without such events.
        silent: share of pixels without an event in 0.51 s.
        fano: variance over mean of the number of events of a pixel in 0.51 s; None without events.
    """

    rates_hz: Floats
    ln_rates: Floats
    variation: tuple[float | None, float | None]
    alternating: float | None
    silent: float
    fano: float | None


def measure_pixel_noise(recording: Recording) -> PixelNoise:
    """Measure the noise of each pixel of a static recording that lasts for 0.51 s or more."""
    events, (height, width) = recording.events, recording.shape
    pixel = events["y"].astype(np.int64) * width + events["x"]
    order = np.lexsort((events["t"], pixel))
    pixel, on, t_us = pixel[order], events["p"][order].astype(bool), events["t"][order]
    counts = np.array(
        [event_counts(events[events["p"] == p], recording.shape).ravel() for p in (True, False)]
    )
    rates = counts / (recording.duration_us * 1e-6)
    enough = (counts >= _FEWEST_EVENTS).all(axis=0)
    same_pixel = np.diff(pixel) == 0
    in_window = _window_counts(pixel, t_us, height * width, recording.duration_us, WINDOW_US)
    mean = float(in_window.mean())
    return PixelNoise(
        rates,
        np.log(rates[:, enough]),
        (_variation(pixel[on], t_us[on]), _variation(pixel[~on], t_us[~on])),
        float((np.diff(on)[same_pixel]).mean()) if same_pixel.any() else None,
        float((in_window == 0).mean()),
        float(in_window.var()) / mean if mean > 0.0 else None,
    )


def _window_counts(
    pixel: npt.NDArray[np.int64],
    t_us: npt.NDArray[np.int64],
    pixels: int,
    duration_us: int,
    window_us: int,
) -> npt.NDArray[np.int64]:
    """Return the number of events of each pixel in each whole window, (windows × pixels,)."""
    windows = max(duration_us // window_us, 1)
    window = t_us // window_us
    whole = window < windows
    return np.bincount(window[whole] * pixels + pixel[whole], minlength=windows * pixels)


def _variation(pixel: npt.NDArray[np.int64], t_us: npt.NDArray[np.int64]) -> float | None:
    """Return the mean coefficient of variation of the intervals of a pixel, with time sorted."""
    same_pixel = np.diff(pixel) == 0
    interval, owner = np.diff(t_us)[same_pixel].astype(np.float64), pixel[1:][same_pixel]
    number = np.bincount(owner)
    enough = number >= _FEWEST_EVENTS
    if np.count_nonzero(enough) < _FEWEST_PIXELS:
        return None
    mean = np.bincount(owner, interval)[enough] / number[enough]
    square = np.bincount(owner, interval**2)[enough] / number[enough]
    return float((np.sqrt(np.maximum(square - mean**2, 0.0)) / mean).mean())


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on the noise of single pixels."""
    dim, dark = (
        measure_pixel_noise(record_static(config, chip_lux=lux, seed=seed))
        for lux in (DIM_LUX, DARK_LUX)
    )
    at = f"at {lux_label(DIM_LUX)}"
    return Section(
        "Noise of single pixels",
        f"Static recordings as above. Figures {at} stand beside those of Joubert 2021, whose "
        "sensor was much noisier; its thresholds are about half as high, if its illuminance is on "
        "the scene. Figures in the dark stand beside those of the dark floor of a clip of a "
        "DAVIS346. Logarithms are those of pixels with five events of each polarity or more. An "
        "event alternates if its polarity differs from that of the pixel's event before. Intervals "
        "are counted in windows as long as the recordings of Joubert 2021.",
        [
            *_dim_rows(dim, at),
            *(row for lux in sources.RECORDED_S for row in _interval_rows(config, lux, seed=seed)),
            *_dark_rows(dark),
        ],
        [_rate_plot(dim, at)],
    )


def _dim_rows(noise: PixelNoise, at: str) -> list[Quantity]:
    quantiles = np.percentile(noise.rates_hz[0], _QUANTILES).tolist()
    rows = [
        Quantity(f"{p} % of the pixels: ON rate below, {at}", "Hz", x, sources.ON_QUANTILES_HZ[p])
        for p, x in zip(_QUANTILES, quantiles, strict=True)
    ]
    on, off = noise.ln_rates
    for k, (name, values) in enumerate((("ON", on), ("OFF", off))):
        published = sources.LN_RATE_DEVIATION[k]
        rows.append(_deviation_row(f"deviation of ln({name} rate), {at}", values, published))
    few = on.size < _FEWEST_PIXELS
    mean = None if few else float((on - off).mean())
    note = _few(few)
    rows.append(Quantity(f"mean of ln(ON/OFF), {at}", "", mean, sources.LN_RATIO_MEAN, note))
    rows.append(
        _deviation_row(f"deviation of ln(ON/OFF), {at}", on - off, sources.LN_RATIO_DEVIATION)
    )
    return rows + [
        Quantity(
            f"variation of the {name} intervals of a pixel, {at}",
            "",
            noise.variation[k],
            sources.INTERVAL_VARIATION[k],
            _few(noise.variation[k] is None),
        )
        for k, name in enumerate(("ON", "OFF"))
    ]


def interval_shares(recording: Recording, *, window_us: int, most: int) -> Floats:
    """Return the shares of the pixels with 0, 1, … `most` intervals between ON events of a window.

    Args:
        recording: a static recording that is at least as long as the window.
        window_us: length of the windows, in which intervals are counted apart [µs].
        most: largest number of intervals.

    Returns:
        (most + 1,) shares of all pixels of all whole windows.
    """
    on = recording.events[recording.events["p"].astype(bool)]
    height, width = recording.shape
    pixel = on["y"].astype(np.int64) * width + on["x"]
    events = _window_counts(pixel, on["t"], height * width, recording.duration_us, window_us)
    intervals = np.maximum(events - 1, 0)
    return np.bincount(intervals, minlength=most + 1)[: most + 1] / intervals.size


def _interval_rows(config: SensorConfig, lux: float, *, seed: int) -> list[Quantity]:
    """Return the shares of the pixels with few intervals, in light in which leak prevails."""
    published, window_s = sources.INTERVALS_PERCENT[lux], sources.RECORDED_S[lux]
    shares = interval_shares(
        record_static(config, chip_lux=lux, seed=seed),
        window_us=round(window_s * 1e6),
        most=len(published) - 1,
    )
    source = f"our analysis of the histograms of {sources.JOUBERT}, {lux_label(lux)}"
    return [
        Quantity(
            f"pixels with {k} ON interval{'' if k == 1 else 's'} in {window_s:g} s at "
            f"{lux_label(lux)}",
            "%",
            100.0 * float(share),
            Published(percent, source),
        )
        for k, (share, percent) in enumerate(zip(shares, published, strict=True))
    ]


def _dark_rows(noise: PixelNoise) -> list[Quantity]:
    alternating = None if noise.alternating is None else 100.0 * noise.alternating
    return [
        Quantity(
            "silent pixels in 0.51 s of dark", "%", 100.0 * noise.silent, sources.SILENT_PERCENT
        ),
        Quantity("Fano factor of the pixels in the dark", "", noise.fano, sources.FANO),
        Quantity(
            "events that alternate in the dark", "%", alternating, sources.ALTERNATION_PERCENT
        ),
    ]


def _deviation_row(name: str, values: Floats, published: Published) -> Quantity:
    few = values.size < _FEWEST_PIXELS
    return Quantity(name, "", None if few else float(values.std()), published, _few(few))


def _few(few: bool) -> str:
    return "too few pixels have five events of each polarity" if few else ""


def _rate_plot(noise: PixelNoise, at: str) -> Plot:
    share = 100.0 * (np.arange(noise.rates_hz.shape[1]) + 0.5) / noise.rates_hz.shape[1]
    lines = [
        series(name, np.where(rates > 0.0, rates, np.nan), share, Style.LINE, k)
        for k, (name, rates) in enumerate(zip(("ON", "OFF"), np.sort(noise.rates_hz), strict=True))
    ]
    known = [published.value for published in sources.ON_QUANTILES_HZ.values()]
    lines.append(
        series("Joubert 2021, ON", known, list(sources.ON_QUANTILES_HZ), Style.PUBLISHED, 0)
    )
    return Plot(
        f"Pixels by their rate {at}",
        "rate of a pixel [Hz]",
        "share of pixels below [%]",
        lines,
        x_log=True,
    )
