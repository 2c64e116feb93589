"""The optical bench: show a small sensor known luminance, and record its output.

Illuminance is given either on the scene, which is an evenly lit grey card, or on the chip behind
the lens.
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
from flybench.events import Events, concatenate_events

REFLECTANCE = 0.18
"""Reflectance of the card (assumed: photographic grey; the sources state only the illuminance)."""

SCENE_LUX = (0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5)
"""Illuminance on the scene, from starlight to sunlight [lux]."""

LONGEST_WAIT_US = 60e6
"""Longest time constant that an experiment waits for [µs]: ten of them fit in one sample step."""

Frame = npt.NDArray[np.float32]
Counts = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Recording:
    """Output of a sensor during one experiment.

    Attributes:
        events: (n,) of `EVENT_DTYPE`.
        causes: (n,) uint8, the `Cause` of each event.
        aps_frames: APS frames.
        shape: rows and columns of the sensor.
        duration_us: time from the first luminance sample to the last [µs].
    """

    events: Events
    causes: npt.NDArray[np.uint8]
    aps_frames: tuple[ApsFrame, ...]
    shape: tuple[int, int]
    duration_us: int


def record(
    config: SensorConfig, samples: Iterable[tuple[int, npt.ArrayLike]], *, seed: int
) -> Recording:
    """Show (time [µs], luminance [cd/m²]) samples to a new sensor and record its whole output."""
    sensor = EventSensor(config, seed=seed)
    times = []

    def noting_times() -> Iterable[tuple[int, npt.ArrayLike]]:
        for t_us, luminance in samples:
            times.append(t_us)
            yield t_us, luminance

    outputs = list(sensor.stream(noting_times()))
    return Recording(
        concatenate_events([output.events for output in outputs]),
        np.concatenate([output.causes for output in outputs]),
        tuple(frame for output in outputs for frame in output.aps_frames),
        (config.height, config.width),
        times[-1] - times[0],
    )


def bench_sensor(config: SensorConfig, *, width: int, height: int) -> SensorConfig:
    """Return a sensor with the same pixels in an array of another size, for an experiment.

    Its readout has no limit, so that pixels never wait. Frames, which these experiments do not use,
    are as rare as the configuration allows.
    """
    return replace(
        config,
        width=width,
        height=height,
        readout=UNLIMITED,
        aps=replace(config.aps, period_min_us=10_000_000),
    )


def chip_lux_per_scene_lux(config: SensorConfig) -> float:
    """Return the illuminance on the chip for each lux on the grey card."""
    return REFLECTANCE / math.pi * _chip_lux_per_cd_m2(config)


def chip_luminance(config: SensorConfig, chip_lux: npt.ArrayLike) -> Frame:
    """Return the scene luminance [cd/m²] that gives `chip_lux` on the chip, of the same shape."""
    return np.asarray(np.asarray(chip_lux) / _chip_lux_per_cd_m2(config), np.float32)


def scene_luminance(scene_lux: npt.ArrayLike) -> Frame:
    """Return the luminance of the grey card [cd/m²] under `scene_lux`, of the same shape."""
    return np.asarray(np.asarray(scene_lux) * (REFLECTANCE / math.pi), np.float32)


def uniform_frame(config: SensorConfig, luminance: npt.ArrayLike) -> Frame:
    """Return a frame of one luminance [cd/m²]."""
    return np.full((config.height, config.width), luminance, np.float32)


def column_frame(config: SensorConfig, luminance: npt.ArrayLike) -> Frame:
    """Return a frame with one luminance for each column, (width,) [cd/m²]."""
    row = np.asarray(luminance, np.float32)
    return np.ascontiguousarray(np.broadcast_to(row, (config.height, config.width)))


def time_constant_us(config: SensorConfig, chip_lux: float) -> float:
    """Return the nominal time constants of photoreceptor and follower, added [µs].

    The result is kept between 1 µs and 1 min. It only sets how long an experiment waits, never what
    it measures.
    """
    corner_hz = min(
        config.bandwidth_limit_hz, config.bandwidth_hz_per_lux * (chip_lux + config.warm_dark_lux)
    )
    follower_s = 1.0 / config.follower_hz if config.follower_hz > 0.0 else 0.0
    tau_us = 1e6 * (1.0 / corner_hz + follower_s) / (2.0 * math.pi)
    return min(max(1.0, tau_us), LONGEST_WAIT_US)


def event_counts(events: Events, shape: tuple[int, int]) -> Counts:
    """Count the events of each pixel, (height, width)."""
    height, width = shape
    flat = events["y"].astype(np.int64) * width + events["x"]
    return np.bincount(flat, minlength=height * width).reshape(shape)


def events_between(events: Events, start_us: int, end_us: int) -> Events:
    """Return the events in (start, end]."""
    first, last = np.searchsorted(events["t"], [start_us, end_us], side="right")
    return events[first:last]


def first_times_us(events: Events, shape: tuple[int, int]) -> npt.NDArray[np.float64]:
    """Return the time of each pixel's first event, (height, width); NaN without events [µs]."""
    times = np.full(shape, np.inf)
    np.minimum.at(times, (events["y"], events["x"]), events["t"])
    return np.where(np.isfinite(times), times, np.nan)


def static_samples(
    luminance: Frame, *, duration_s: float, step_s: float = 1.0
) -> list[tuple[int, Frame]]:
    """Return luminance samples of a static scene."""
    step_us = round(step_s * 1e6)
    return [(t_us, luminance) for t_us in range(0, round(duration_s * 1e6) + 1, step_us)]


def log_spaced(low: float, high: float, per_decade: int) -> npt.NDArray[np.float64]:
    """Return values from `low` to `high`, evenly spaced in the logarithm."""
    number = round(per_decade * math.log10(high / low)) + 1
    return np.geomspace(low, high, number)


def lux_label(lux: float) -> str:
    """Format an illuminance for a label, such as "100 lux" or "1 klux"."""
    return f"{lux / 1000:g} klux" if lux >= 1000.0 else f"{lux:g} lux"


def nan_for_none(values: Sequence[float | None]) -> list[float]:
    """Return the values with NaN for None, for a curve with gaps."""
    return [math.nan if value is None else value for value in values]


def _chip_lux_per_cd_m2(config: SensorConfig) -> float:
    return lux_per_cd_m2(f_number=config.f_number, transmission=config.transmission)
