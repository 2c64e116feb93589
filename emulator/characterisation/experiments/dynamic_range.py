"""Dynamic range of the events: from the dimmest to the brightest scene that still causes them.

Definition: a bar that removes 80 % of the luminance passes a grey card. An illuminance is in range
if at least half of the pixels respond to the arrival or the departure of the bar with a signal
event. (The emulator knows the cause of each event; on a real sensor, counting has to separate
signal from noise.) The range is 20·log10 of the brightest over the dimmest such illuminance. It
ends at 100 klux like the published ranges, since sunlight is the brightest scene.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    bench_sensor,
    chip_luminance,
    chip_lux_per_scene_lux,
    event_counts,
    log_spaced,
    record,
    time_constant_us,
    uniform_frame,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from flybench.events import Cause

DARKENING = 0.8
"""Share of luminance that the bar removes (assumed: black print on grey paper; the sources do not
state it)."""
BRIGHTEST_LUX = 1e5
"""Illuminance of the scene in sunlight [lux]."""
_HALF = 0.5
"""Share of pixels that has to respond, as at the threshold of an S-curve."""
_STAY = 5.0
"""How long the bar stays, in time constants of the photoreceptor behind it."""
SIDE_PX = 32
"""Side of the array: a thousand pixels give a share to within 1.6 %."""

Floats = npt.NDArray[np.float64]


def responding_share(config: SensorConfig, *, chip_lux: float, seed: int) -> float:
    """Return the share of pixels that respond to a bar before a card of `chip_lux` on the chip."""
    sensor = bench_sensor(config, width=SIDE_PX, height=SIDE_PX)
    bright = uniform_frame(sensor, chip_luminance(sensor, chip_lux))
    dark = np.asarray((1.0 - DARKENING) * bright, np.float32)
    stay_us = math.ceil(_STAY * time_constant_us(config, (1.0 - DARKENING) * chip_lux)) + 10
    start_us = 1000
    gone_us = start_us + stay_us
    samples = [
        (0, bright),
        (start_us, bright),
        (start_us + 1, dark),
        (gone_us, dark),
        (gone_us + 1, bright),
        (gone_us + stay_us, bright),
    ]
    recording = record(sensor, samples, seed=seed)
    events = recording.events[recording.causes == Cause.SIGNAL]
    passing = events[events["t"] > start_us]
    return float((event_counts(passing, recording.shape) > 0).mean())


def dynamic_range_db(scene_lux: Floats, share: Floats) -> float | None:
    """Return the dynamic range [dB]; None if half of the pixels never respond.

    The ends are interpolated in the logarithm of the illuminance.

    Args:
        scene_lux: (n,) rising illuminances on the scene [lux].
        share: (n,) share of pixels that respond at each.
    """
    in_range = np.flatnonzero(share >= _HALF)
    if in_range.size == 0:
        return None
    log_lux = np.log10(scene_lux)
    first, last = int(in_range[0]), int(in_range[-1])
    low = _crossing(log_lux, share, first - 1) if first > 0 else log_lux[0]
    high = _crossing(log_lux, share, last) if last < share.size - 1 else log_lux[-1]
    return float(20.0 * (high - low))


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on the dynamic range of the events."""
    lux = log_spaced(1e-3, BRIGHTEST_LUX, 5)
    scale = chip_lux_per_scene_lux(config)
    share = np.array([responding_share(config, chip_lux=x * scale, seed=seed) for x in lux])
    found = dynamic_range_db(lux, share)
    dimmest = None if found is None else BRIGHTEST_LUX / 10.0 ** (found / 20.0)
    note = "the model has no upper limit; only the lower one is measured"
    return Section(
        "Dynamic range of the events",
        "A bar that removes 80 % of the luminance passes a grey card of 18 % reflectance. The "
        "range is 20·log10 of the highest over the lowest illuminance at which half of the pixels "
        "respond to the arrival or the departure of the bar with a signal event. It ends at 100 "
        "klux.",
        [
            Quantity("dynamic range", "dB", found, sources.DYNAMIC_RANGE_DB, note),
            Quantity("dynamic range", "dB", found, sources.DYNAMIC_RANGE_DAVIS240_DB, note),
            Quantity("lowest illuminance on the scene", "lux", dimmest),
        ],
        [
            Plot(
                "Pixels that respond to a bar of 80 %",
                "illuminance on the scene [lux]",
                "share of pixels",
                [
                    series("measured", lux, share, Style.LINE, 0),
                    series("half", [lux[0], lux[-1]], [_HALF, _HALF], Style.GUIDE),
                ],
                x_log=True,
            )
        ],
    )


def _crossing(log_lux: Floats, share: Floats, i: int) -> float:
    """Interpolate where the share is one half between illuminance `i` and the next."""
    part = (_HALF - share[i]) / (share[i + 1] - share[i])
    return float(log_lux[i] + part * (log_lux[i + 1] - log_lux[i]))
