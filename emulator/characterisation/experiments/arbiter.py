"""The readout: how many events it passes on, how late, and how many it loses.

Every pixel flickers with a phase of its own, so that events come at a steady rate. The same sensor,
same seed, same light, is read out twice: by a bus without limits, which shows what the pixels make,
and by its arbiter. A pixel waits with one event at a time, and after it was read it is in reset for
its refractory period; so the event that comes out is the first that the pixel made since, which
gives its delay.

Rates are counted between two time stamps, late enough for the queue to have filled: a row's events
share the stamp of its grant, so that of the last row the bus has carried none yet at its stamp, and
of the first all until the next. Over the whole of a short record the last row would count as
carried, and the bus would seem to carry more than it can.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    Frame,
    chip_luminance,
    decades,
    of_light,
    record,
    resized,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from flybench.events import Events

WIDTH, HEIGHT = 128, 96
"""Enough pixels to fill the bus of the DAVIS346 ten times over at the fastest flicker."""
CHIP_LUX = 2000.0
"""Bright enough for the full bandwidth, and for hardly any noise [lux]."""
SWING = 1.0
"""Of the flicker, peak to peak [ln units of light]."""
_SAMPLES = 24
"""A cycle: straight lines between them stay within 1 % of the sine."""
_LEAST_SAMPLES, _MOST_SAMPLES = 60, 200
"""From two and a half cycles to eight."""
_SETTLING = 0.3
"""Share of a record in which the queue fills, and which does not count."""
_EVENTS = 120_000
"""About how many are drawn at each load."""
_LOSS = 0.01
"""Share of the events whose loss makes a readout crowded."""
_TIME_BITS = 40
"""Of a key that holds pixel and time: 12 days."""
_SHORTEST_US = 0.01
"""Mean delay below which none is drawn."""

Longs = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Load:
    """The readout under one load.

    Attributes:
        in_hz: events that the pixels make a second [Hz], counted over the same time as out_hz.
        out_hz: events that come out a second [Hz], see `rates_hz`.
        mean_us: mean delay of those [µs].
        slowest_us: delay that one in a hundred of them exceeds [µs].
    """

    in_hz: float
    out_hz: float
    mean_us: float
    slowest_us: float


def measure_load(config: SensorConfig, *, flicker_hz: float, seed: int) -> Load | None:
    """Readout of an array that flickers at one frequency [Hz]; None where nothing comes out."""
    free = resized(config, width=WIDTH, height=HEIGHT)
    bound = replace(free, readout=config.readout)
    samples = _flicker(free, flicker_hz, seed)
    made = record(free, samples, seed=seed).events
    passed = record(bound, samples, seed=seed).events
    delays = delays_us(
        made,
        passed,
        width=WIDTH,
        reset_us=max(1, config.refractory_us) - config.readout.latency_us,
    )
    rates = rates_hz(made, passed, from_us=round(_SETTLING * samples[-1][0]))
    if delays.size == 0 or rates is None:
        return None
    return Load(
        *rates,
        float(delays.mean()),
        float(np.percentile(delays, 99.0)),
    )


def rates_hz(made: Events, passed: Events, *, from_us: int) -> tuple[float, float] | None:
    """Rates in and out, from the first stamp after a time to the last stamp.

    Args:
        made: events as the pixels make them, sorted by t.
        passed: events as they come out, sorted by t.
        from_us: when to begin [µs].

    Returns:
        Events a second, made and passed on [Hz]; None where fewer than two stamps are left.
    """
    stamps = passed["t"][passed["t"] >= from_us]
    if stamps.size == 0 or stamps[0] == stamps[-1]:
        return None
    span_us = int(stamps[-1] - stamps[0])
    number = [np.diff(np.searchsorted(x["t"], stamps[[0, -1]])).item() for x in (made, passed)]
    return 1e6 * number[0] / span_us, 1e6 * number[1] / span_us


def delays_us(made: Events, passed: Events, *, width: int, reset_us: int) -> Longs:
    """Delays of the events that came out.

    Args:
        made: events as the pixels make them, sorted by t.
        passed: events as they come out, sorted by t.
        width: columns of the sensor [px].
        reset_us: how long after its last event came out a pixel makes none that counts [µs].

    Returns:
        (n,) delays, pixel by pixel [µs].
    """
    before, after = _by_pixel(made, width), _by_pixel(passed, width)
    pixel = after >> _TIME_BITS
    again = np.diff(pixel, prepend=-1) == 0
    since = np.where(again, np.roll(after, 1) + reset_us, pixel << _TIME_BITS)
    place = np.minimum(np.searchsorted(before, since), before.size - 1)
    delay = after - before[place]
    return np.asarray(delay[(before[place] >> _TIME_BITS == pixel) & (delay >= 0)], np.int64)


def measure(config: SensorConfig, *, seed: int) -> Section:
    """The readout of the data sheet."""
    found = [measure_load(config, flicker_hz=float(f), seed=seed) for f in decades(1.0, 1000.0, 4)]
    loads = [load for load in found if load is not None]
    rates = np.array([load.in_hz for load in loads])
    losing_hz = rate_that_loses(loads, _LOSS)
    crowded = any(load.out_hz < (1.0 - _LOSS) * load.in_hz for load in loads)
    most_hz = max(load.out_hz for load in loads) if crowded else None
    unlimited = "" if crowded else "all that the pixels made came out"
    never_calm = "the slowest flicker loses more" if crowded and losing_hz is None else ""
    return Section(
        "Readout",
        f"{WIDTH}×{HEIGHT} pixels flicker by {math.exp(SWING):.1f} to 1, each with a phase of its "
        "own, slowly at first and then faster and faster; read out by a bus without limits, which "
        "gives the rate in, and by the arbiter. Each row that is read takes a word of the bus, as "
        "each event does, so that the greatest rate lies below the words a second that the bus "
        "carries.",
        [
            Quantity(
                "greatest rate out", "Mev/s", _mega(most_hz), sources.ARBITER_MEV_S, unlimited
            ),
            Quantity("rate in that loses 1 %", "Mev/s", _mega(losing_hz), note=never_calm),
            Quantity("mean delay at half the greatest rate", "µs", _delay_at(loads, most_hz, 0.5)),
            Quantity(
                "longest delay but for 1 %", "µs", max((x.slowest_us for x in loads), default=None)
            ),
        ],
        [_rate_plot(rates, loads), _delay_plot(rates, loads)],
    )


def rate_that_loses(loads: list[Load], share: float) -> float | None:
    """Rate in at which `share` of the events is lost, by interpolation; None if none is."""
    lost = np.array([1.0 - load.out_hz / load.in_hz for load in loads])
    beyond = np.flatnonzero(lost > share)
    if beyond.size == 0 or beyond[0] == 0:
        return None
    i = int(beyond[0])
    part = (share - lost[i - 1]) / (lost[i] - lost[i - 1])
    low, high = (math.log(loads[k].in_hz) for k in (i - 1, i))
    return math.exp(low + part * (high - low))


def _delay_at(loads: list[Load], most_hz: float | None, share: float) -> float | None:
    """Mean delay where `share` of the greatest rate comes in, by interpolation [µs].

    None where nothing was lost, or no load was as low.
    """
    if most_hz is None or share * most_hz < loads[0].in_hz:
        return None
    rates = np.log([load.in_hz for load in loads])
    return float(np.interp(math.log(share * most_hz), rates, [load.mean_us for load in loads]))


def _flicker(config: SensorConfig, flicker_hz: float, seed: int) -> list[tuple[int, Frame]]:
    """Light of pixels that flicker out of step, long enough for `_EVENTS` or so."""
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, (HEIGHT, WIDTH))
    step_us = max(1, round(1e6 / (flicker_hz * _SAMPLES)))
    events_a_step = 2.0 * SWING / config.theta_on * WIDTH * HEIGHT / _SAMPLES
    number = min(max(_LEAST_SAMPLES, math.ceil(_EVENTS / events_a_step)), _MOST_SAMPLES)
    base = chip_luminance(config, CHIP_LUX)
    samples = []
    for k in range(number + 1):
        wave = np.sin(2.0 * math.pi * flicker_hz * k * step_us * 1e-6 + phase)
        samples.append((k * step_us, np.asarray(base * np.exp(0.5 * SWING * wave), np.float32)))
    return samples


def _by_pixel(events: Events, width: int) -> Longs:
    """Pixel and time of each event as one number, sorted."""
    pixel = events["y"].astype(np.int64) * width + events["x"]
    return np.sort((pixel << _TIME_BITS) + events["t"])


def _mega(rate_hz: float | None) -> float | None:
    return None if rate_hz is None else 1e-6 * rate_hz


def _rate_plot(rates: npt.NDArray[np.float64], loads: list[Load]) -> Plot:
    return Plot(
        "Events in and out",
        "rate in [Mev/s]",
        "rate out [Mev/s]",
        [
            series("measured", 1e-6 * rates, [1e-6 * x.out_hz for x in loads], Style.LINE, 0),
            series("all of them", 1e-6 * rates, 1e-6 * rates, Style.GUIDE),
        ],
        x_log=True,
        y_log=True,
    )


def _delay_plot(rates: npt.NDArray[np.float64], loads: list[Load]) -> Plot:
    mean = of_light([x.mean_us if x.mean_us > _SHORTEST_US else None for x in loads])
    slowest = of_light([x.slowest_us or None for x in loads])
    return Plot(
        "Delay of the readout",
        "rate in [Mev/s]",
        "delay [µs]",
        [
            series("mean", 1e-6 * rates, mean, Style.LINE, 0),
            series("1 in 100 is slower", 1e-6 * rates, slowest, Style.LINE, 1),
        ],
        x_log=True,
        y_log=True,
    )
