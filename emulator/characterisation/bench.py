"""The optical bench: known light onto a small sensor, and what comes out of it.

Illuminance is given either on the scene, an evenly lit grey card, or on the chip behind the lens.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from emulator.aps.frames import ApsFrame
from emulator.config import SensorConfig
from emulator.pixel.optics import lux_per_cd_m2
from emulator.readout.config import UNLIMITED
from emulator.sensor import EventSensor
from flybench.events import Events, joined

REFLECTANCE = 0.18
"""Of the card (assumed: photographic grey, since the sources name only the light on the scene)."""

SCENE_LUX = (0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5)
"""Starlight to sunlight, on the scene [lux]."""

LONGEST_WAIT_US = 60e6
"""Time constant that an experiment waits for at most: ten of them still make one step of light."""

Frame = npt.NDArray[np.float32]
Counts = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Recording:
    """What came out of the sensor.

    Attributes:
        events: (n,) of `EVENT_DTYPE`.
        causes: (n,) uint8, the `Cause` of each.
        aps_frames: the frames.
        shape: rows and columns of the sensor.
        duration_us: from the first sample of light to the last [µs].
    """

    events: Events
    causes: npt.NDArray[np.uint8]
    aps_frames: tuple[ApsFrame, ...]
    shape: tuple[int, int]
    duration_us: int


def record(
    config: SensorConfig, samples: Iterable[tuple[int, npt.ArrayLike]], *, seed: int
) -> Recording:
    """Show a new sensor (time [µs], luminance [cd/m²]) samples and keep all that it says."""
    sensor = EventSensor(config, seed=seed)
    times = []

    def noted() -> Iterable[tuple[int, npt.ArrayLike]]:
        for t_us, luminance in samples:
            times.append(t_us)
            yield t_us, luminance

    outputs = list(sensor.stream(noted()))
    return Recording(
        joined([output.events for output in outputs]),
        np.concatenate([output.causes for output in outputs]),
        tuple(frame for output in outputs for frame in output.aps_frames),
        (config.height, config.width),
        times[-1] - times[0],
    )


def resized(config: SensorConfig, *, width: int, height: int) -> SensorConfig:
    """The same pixels in another number, with a readout that never makes them wait.

    Frames, which these experiments don't look at, are made as rare as can be.
    """
    return replace(
        config,
        width=width,
        height=height,
        readout=UNLIMITED,
        aps=replace(config.aps, period_min_us=10_000_000),
    )


def chip_lux_per_scene_lux(config: SensorConfig) -> float:
    """Illuminance on the chip per illuminance on the grey card."""
    return REFLECTANCE / math.pi * _chip_lux_per_cd_m2(config)


def chip_luminance(config: SensorConfig, chip_lux: npt.ArrayLike) -> Frame:
    """Luminance of the scene [cd/m²] that puts `chip_lux` on the chip, in its shape."""
    return np.asarray(np.asarray(chip_lux) / _chip_lux_per_cd_m2(config), np.float32)


def scene_luminance(scene_lux: npt.ArrayLike) -> Frame:
    """Luminance of the grey card [cd/m²] under `scene_lux`, in its shape."""
    return np.asarray(np.asarray(scene_lux) * (REFLECTANCE / math.pi), np.float32)


def uniform(config: SensorConfig, luminance: npt.ArrayLike) -> Frame:
    """A frame of one luminance [cd/m²]."""
    return np.full((config.height, config.width), luminance, np.float32)


def columns(config: SensorConfig, luminance: npt.ArrayLike) -> Frame:
    """A frame whose columns have the luminances given, (width,) [cd/m²]."""
    row = np.asarray(luminance, np.float32)
    return np.ascontiguousarray(np.broadcast_to(row, (config.height, config.width)))


def time_constant_us(config: SensorConfig, chip_lux: float) -> float:
    """Time constants of photoreceptor and follower that the maker promises, added; 1 µs to 1 min.

    It only sets how long an experiment waits, never what it measures.
    """
    corner_hz = min(
        config.bandwidth_limit_hz, config.bandwidth_hz_per_lux * (chip_lux + config.warm_dark_lux)
    )
    follower_s = 1.0 / config.follower_hz if config.follower_hz > 0.0 else 0.0
    tau_us = 1e6 * (1.0 / corner_hz + follower_s) / (2.0 * math.pi)
    return min(max(1.0, tau_us), LONGEST_WAIT_US)


def counts(events: Events, shape: tuple[int, int]) -> Counts:
    """Events of each pixel, (height, width)."""
    height, width = shape
    flat = events["y"].astype(np.int64) * width + events["x"]
    return np.bincount(flat, minlength=height * width).reshape(shape)


def between(events: Events, start_us: int, end_us: int) -> Events:
    """Events in (start, end]."""
    first, last = np.searchsorted(events["t"], [start_us, end_us], side="right")
    return events[first:last]


def first_times_us(events: Events, shape: tuple[int, int]) -> npt.NDArray[np.float64]:
    """Time of each pixel's first event, (height, width), NaN where there is none [µs]."""
    times = np.full(shape, np.inf)
    np.minimum.at(times, (events["y"], events["x"]), events["t"])
    return np.where(np.isfinite(times), times, np.nan)


def static_samples(
    luminance: Frame, *, duration_s: float, step_s: float = 1.0
) -> list[tuple[int, Frame]]:
    """Samples of a scene that does not change."""
    step_us = round(step_s * 1e6)
    return [(t_us, luminance) for t_us in range(0, round(duration_s * 1e6) + 1, step_us)]


def decades(low: float, high: float, per_decade: int) -> npt.NDArray[np.float64]:
    """Values from `low` to `high`, evenly spaced in the logarithm."""
    number = round(per_decade * math.log10(high / low)) + 1
    return np.geomspace(low, high, number)


def light_label(lux: float) -> str:
    """A light as people write it."""
    return f"{lux / 1000:g} klux" if lux >= 1000.0 else f"{lux:g} lux"


def of_light(values: Sequence[float | None]) -> list[float]:
    """A column for a curve: None becomes NaN."""
    return [math.nan if value is None else value for value in values]


def _chip_lux_per_cd_m2(config: SensorConfig) -> float:
    return lux_per_cd_m2(f_number=config.f_number, transmission=config.transmission)
