"""Dynamic range of the events: from the dimmest to the brightest scene that still makes them.

Definition: a bar that takes 80 % of the light away passes a grey card; the light counts where at
least half of the pixels answer the bar's coming or going with an event that the signal made. (The
emulator knows the cause of each event; on a real sensor noise has to be told apart by counting.)
The range is 20·log10 of the brightest over the dimmest such light, counted up to 100 klux as the
published ones are, since sunlight is the brightest scene.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import (
    chip_luminance,
    chip_lux_per_scene_lux,
    counts,
    decades,
    record,
    resized,
    time_constant_us,
    uniform,
)
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig
from flybench.events import Cause

DARKENING = 0.8
"""Of the bar (assumed: what black print takes from grey paper; the sources do not say)."""
BRIGHTEST_LUX = 1e5
"""Sunlight, on the scene [lux]."""
_HALF = 0.5
"""Share of pixels that counts as an answer, as at the threshold of an S-curve."""
_STAY = 5.0
"""How long the bar stays, in time constants of the photoreceptor in its shade."""
SIDE_PX = 32
"""A thousand pixels: a share is known to 1.6 %."""

Floats = npt.NDArray[np.float64]


def answering_share(config: SensorConfig, *, chip_lux: float, seed: int) -> float:
    """Share of pixels that answer a bar before `chip_lux` on the chip."""
    sensor = resized(config, width=SIDE_PX, height=SIDE_PX)
    light = uniform(sensor, chip_luminance(sensor, chip_lux))
    dark = np.asarray((1.0 - DARKENING) * light, np.float32)
    stay_us = math.ceil(_STAY * time_constant_us(config, (1.0 - DARKENING) * chip_lux)) + 10
    start_us = 1000
    gone_us = start_us + stay_us
    samples = [
        (0, light),
        (start_us, light),
        (start_us + 1, dark),
        (gone_us, dark),
        (gone_us + 1, light),
        (gone_us + stay_us, light),
    ]
    recording = record(sensor, samples, seed=seed)
    events = recording.events[recording.causes == Cause.SIGNAL]
    passing = events[events["t"] > start_us]
    return float((counts(passing, recording.shape) > 0).mean())


def dynamic_range_db(scene_lux: Floats, share: Floats) -> float | None:
    """Range from (n,) lights in rising order and (n,) shares; None where half never answer.

    The ends are interpolated in the logarithm of the light.
    """
    answers = np.flatnonzero(share >= _HALF)
    if answers.size == 0:
        return None
    log_lux = np.log10(scene_lux)
    first, last = int(answers[0]), int(answers[-1])
    low = _crossing(log_lux, share, first - 1) if first > 0 else log_lux[0]
    high = _crossing(log_lux, share, last) if last < share.size - 1 else log_lux[-1]
    return float(20.0 * (high - low))


def measure(config: SensorConfig, *, seed: int) -> Section:
    """The dynamic range of the data sheet."""
    lux = decades(1e-3, BRIGHTEST_LUX, 5)
    scale = chip_lux_per_scene_lux(config)
    share = np.array([answering_share(config, chip_lux=x * scale, seed=seed) for x in lux])
    found = dynamic_range_db(lux, share)
    dimmest = None if found is None else BRIGHTEST_LUX / 10.0 ** (found / 20.0)
    note = "the model has no upper end, so that the lower one decides"
    return Section(
        "Dynamic range of the events",
        "A bar that takes 80 % of the light away passes a grey card of 18 %. The range is 20·log10 "
        "of the brightest light over the dimmest at which half of the pixels answer the bar's "
        "coming or going with an event that the signal made, counted up to 100 klux.",
        [
            Quantity("dynamic range", "dB", found, sources.DYNAMIC_RANGE_DB, note),
            Quantity("the same", "dB", found, sources.DYNAMIC_RANGE_DAVIS240_DB, note),
            Quantity("dimmest light on the scene", "lux", dimmest),
        ],
        [
            Plot(
                "Pixels that answer a bar of 80 %",
                "light on the scene [lux]",
                "share of pixels",
                [
                    series("measured", lux, share, Style.LINE, 0),
                    series("half of them", [lux[0], lux[-1]], [_HALF, _HALF], Style.GUIDE),
                ],
                x_log=True,
            )
        ],
    )


def _crossing(log_lux: Floats, share: Floats, i: int) -> float:
    """Where the share meets one half between light `i` and the next."""
    part = (_HALF - share[i]) / (share[i + 1] - share[i])
    return float(log_lux[i] + part * (log_lux[i + 1] - log_lux[i]))
