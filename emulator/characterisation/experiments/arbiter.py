"""The readout: how many events it carries, with what delay, and how many it loses.

Every pixel flickers with its own phase, so that events come at a steady rate. One sensor with one
seed and one stimulus is read out twice: by a bus without limits, which shows the events that the
pixels generate, and by its arbiter. A pixel holds only one waiting event, and is in reset for its
refractory period after it was read. An event that is read out is therefore the first that the pixel
generated after its last reset; this gives the delay.

Rates are counted between two time stamps, late enough for the queue to have filled. The events of a
row share the time stamp of its grant. At that time the bus has carried none of the last row yet,
and carries the first row until the next grant. Counted over a whole short recording, the last row
would be included, and the rate would exceed what the bus can carry.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    Frame,
    bench_sensor,
    chip_luminance,
    log_spaced,
    nan_for_none,
    record,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from flybench.events import Events

WIDTH, HEIGHT = 128, 96
"""Size of the array: it loads the bus of the DAVIS346 tenfold at the fastest flicker."""
CHIP_LUX = 2000.0
"""Illuminance on the chip: bright enough for the full bandwidth and hardly any noise [lux]."""
SWING = 3.0
"""Peak-to-peak amplitude of the flicker [ln units of luminance]: large, since the source follower
and the refractory period limit the events of a pixel."""
_SAMPLES = 24
"""Samples per cycle: straight lines between them stay within 1 % of the sine."""
_FEWEST_SAMPLES, _MOST_SAMPLES = 30, 200
"""Samples in a recording: one and a quarter to eight cycles."""
_SETTLING = 0.3
"""Share of a recording in which the queue fills, and which is not counted."""
_EVENTS = 120_000
"""Approximate number of events to generate at each load."""
_LOSS = 0.01
"""Share of lost events above which the readout is overloaded."""
_TIME_BITS = 40
"""Bits for the time in a key of pixel and time: they last for 12 days."""
_SHORTEST_US = 0.01
"""Mean delay below which the plot shows none [µs]."""

Longs = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Load:
    """The readout under one load.

    Attributes:
        in_hz: rate of generated events, counted over the same time as `out_hz` [Hz].
        out_hz: rate of events that are read out; see `rates_hz` [Hz].
        mean_us: mean delay of the events read out [µs].
        percentile_99_us: delay that one in a hundred of them exceeds [µs].
    """

    in_hz: float
    out_hz: float
    mean_us: float
    percentile_99_us: float


def measure_load(config: SensorConfig, *, flicker_hz: float, seed: int) -> Load | None:
    """Measure the readout of an array that flickers at one frequency.

    Args:
        config: configuration of the sensor; its size is replaced.
        flicker_hz: frequency of the flicker [Hz].
        seed: seed of the sensor and of the phases.

    Returns:
        Rates and delays; None if the readout gives too few events.
    """
    unlimited = bench_sensor(config, width=WIDTH, height=HEIGHT)
    limited = replace(
        unlimited,
        readout=config.readout,
    )
    samples = _flicker(unlimited, flicker_hz, seed)
    generated = record(unlimited, samples, seed=seed).events
    read_out = record(limited, samples, seed=seed).events
    delays = delays_us(
        generated,
        read_out,
        width=WIDTH,
        reset_us=max(1, config.refractory_us) - config.readout.latency_us,
    )
    rates = rates_hz(generated, read_out, from_us=round(_SETTLING * samples[-1][0]))
    if delays.size == 0 or rates is None:
        return None
    return Load(*rates, float(delays.mean()), float(np.percentile(delays, 99.0)))


def rates_hz(generated: Events, read_out: Events, *, from_us: int) -> tuple[float, float] | None:
    """Return input and output rates between the first time stamp after a time and the last.

    Args:
        generated: events as the pixels generate them, sorted by t.
        read_out: events as they are read out, sorted by t.
        from_us: start of the count [µs].

    Returns:
        Rates of generated events and of events read out [Hz]; None if fewer than two time stamps
        are left.
    """
    stamps = read_out["t"][read_out["t"] >= from_us]
    if stamps.size == 0 or stamps[0] == stamps[-1]:
        return None
    span_us = int(stamps[-1] - stamps[0])
    number = [
        np.diff(np.searchsorted(x["t"], stamps[[0, -1]])).item() for x in (generated, read_out)
    ]
    return 1e6 * number[0] / span_us, 1e6 * number[1] / span_us


def delays_us(generated: Events, read_out: Events, *, width: int, reset_us: int) -> Longs:
    """Return the delays of the events that were read out.

    Args:
        generated: events as the pixels generate them, sorted by t.
        read_out: events as they are read out, sorted by t.
        width: columns of the sensor [px].
        reset_us: time after an event was read out in which its pixel cannot fire [µs].

    Returns:
        (n,) delays, sorted by pixel [µs].
    """
    before, after = _by_pixel(generated, width), _by_pixel(read_out, width)
    pixel = after >> _TIME_BITS
    again = np.diff(pixel, prepend=-1) == 0
    since = np.where(again, np.roll(after, 1) + reset_us, pixel << _TIME_BITS)
    place = np.minimum(np.searchsorted(before, since), before.size - 1)
    delay = after - before[place]
    return np.asarray(delay[(before[place] >> _TIME_BITS == pixel) & (delay >= 0)], np.int64)


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on the readout."""
    found = [
        measure_load(config, flicker_hz=float(f), seed=seed) for f in log_spaced(1.0, 1000.0, 4)
    ]
    loads = [load for load in found if load is not None]
    rates = np.array([load.in_hz for load in loads])
    return Section(
        "Readout",
        f"{WIDTH}×{HEIGHT} pixels flicker by {math.exp(SWING):.1f} to 1, each with its own phase, "
        "at rising frequencies. A bus without limits gives the input rate, the arbiter the output "
        f"rate. A line that is read takes {config.readout.line_words} words of the bus, and each "
        "of its events one. So the highest output rate is below the number of words per second "
        "that the bus carries.",
        _quantities(loads),
        [_rate_plot(rates, loads), _delay_plot(rates, loads)],
    )


def _quantities(loads: list[Load]) -> list[Quantity]:
    loss_hz = rate_at_loss(loads, _LOSS)
    overloaded = any(load.out_hz < (1.0 - _LOSS) * load.in_hz for load in loads)
    max_out_hz = max(load.out_hz for load in loads) if overloaded else None
    percentile_99_us = max((load.percentile_99_us for load in loads), default=None)
    no_limit = "" if overloaded else "all events were read out"
    always_lossy = "the slowest flicker loses more" if overloaded and loss_hz is None else ""
    return [
        Quantity(
            "highest output rate", "Mev/s", _mega(max_out_hz), sources.ARBITER_MEV_S, no_limit
        ),
        Quantity("input rate with a loss of 1 %", "Mev/s", _mega(loss_hz), note=always_lossy),
        Quantity("mean delay at half the highest rate", "µs", _delay_at(loads, max_out_hz, 0.5)),
        Quantity("99th percentile of the delay", "µs", percentile_99_us),
    ]


def rate_at_loss(loads: list[Load], share: float) -> float | None:
    """Interpolate the input rate at which `share` of the events is lost [Hz].

    Returns:
        The rate; None if no load loses as much, or the lowest already loses more.
    """
    lost = np.array([1.0 - load.out_hz / load.in_hz for load in loads])
    beyond = np.flatnonzero(lost > share)
    if beyond.size == 0 or beyond[0] == 0:
        return None
    i = int(beyond[0])
    part = (share - lost[i - 1]) / (lost[i] - lost[i - 1])
    low, high = (math.log(loads[k].in_hz) for k in (i - 1, i))
    return math.exp(low + part * (high - low))


def _delay_at(loads: list[Load], max_out_hz: float | None, share: float) -> float | None:
    """Interpolate the mean delay at an input rate of `share` of the highest output rate [µs].

    Returns:
        The delay; None if the readout is never overloaded, or every load is above that rate.
    """
    if max_out_hz is None or share * max_out_hz < loads[0].in_hz:
        return None
    rates = np.log([load.in_hz for load in loads])
    return float(np.interp(math.log(share * max_out_hz), rates, [load.mean_us for load in loads]))


def _flicker(config: SensorConfig, flicker_hz: float, seed: int) -> list[tuple[int, Frame]]:
    """Return luminance samples of pixels that flicker out of step, for about `_EVENTS` events."""
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, (HEIGHT, WIDTH))
    step_us = max(1, round(1e6 / (flicker_hz * _SAMPLES)))
    events_per_step = 2.0 * SWING / config.theta_on * WIDTH * HEIGHT / _SAMPLES
    number = min(max(_FEWEST_SAMPLES, math.ceil(_EVENTS / events_per_step)), _MOST_SAMPLES)
    base = chip_luminance(config, CHIP_LUX)
    samples = []
    for k in range(number + 1):
        wave = np.sin(2.0 * math.pi * flicker_hz * k * step_us * 1e-6 + phase)
        samples.append((k * step_us, np.asarray(base * np.exp(0.5 * SWING * wave), np.float32)))
    return samples


def _by_pixel(events: Events, width: int) -> Longs:
    """Return the pixel and time of each event as one number, sorted."""
    pixel = events["y"].astype(np.int64) * width + events["x"]
    return np.sort((pixel << _TIME_BITS) + events["t"])


def _mega(rate_hz: float | None) -> float | None:
    return None if rate_hz is None else 1e-6 * rate_hz


def _rate_plot(rates: npt.NDArray[np.float64], loads: list[Load]) -> Plot:
    return Plot(
        "Output rate against input rate",
        "input rate [Mev/s]",
        "output rate [Mev/s]",
        [
            series("measured", 1e-6 * rates, [1e-6 * x.out_hz for x in loads], Style.LINE, 0),
            series("without loss", 1e-6 * rates, 1e-6 * rates, Style.GUIDE),
        ],
        x_log=True,
        y_log=True,
    )


def _delay_plot(rates: npt.NDArray[np.float64], loads: list[Load]) -> Plot:
    mean = nan_for_none([x.mean_us if x.mean_us > _SHORTEST_US else None for x in loads])
    percentile_99 = nan_for_none([x.percentile_99_us or None for x in loads])
    return Plot(
        "Delay of the readout",
        "input rate [Mev/s]",
        "delay [µs]",
        [
            series("mean", 1e-6 * rates, mean, Style.LINE, 0),
            series("99th percentile", 1e-6 * rates, percentile_99, Style.LINE, 1),
        ],
        x_log=True,
        y_log=True,
    )
