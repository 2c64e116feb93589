"""Render a short piece of a crossing in several ways, and compare the events.

The piece is rendered in full at several supersamplings and steps, and from keyframes at several
spacings. A noise-free sensor turns each rendering into events, which are compared with those of the
finest one. The defaults of `CrossingConfig` were chosen from these results.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from emulator import EventSensor, SensorConfig
from flybench.events import Events
from scenarios.convergence.matching import WITHIN_US, match
from sim import Crossing, CrossingConfig
from sim.render.filament import Luminance

SENSOR = replace(SensorConfig.ideal(), theta_on=0.2, theta_off=0.2, theta_mismatch=0.035)
"""No noise, no bandwidth limit, and the same thresholds for every rendering, so that only the
renderings differ. The thresholds of the pixels vary as in a DAVIS (Brandli 2014). With equal
thresholds, a long uniform edge would cross a threshold everywhere or nowhere."""


class Rendering(NamedTuple):
    """A way to render a piece of a crossing.

    Attributes:
        kind: "full" or "keyframes".
        supersample: rendered pixels per sensor pixel along each axis.
        step_px: motion of the vehicle from one sample to the next [px].
        spacing_px: motion from one keyframe to the next [px]; 0 for "full".
    """

    kind: str
    supersample: int
    step_px: float
    spacing_px: float = 0.0


REFERENCE = Rendering("full", 6, 0.1)
"""Finer than all other renderings."""
FULL = tuple(Rendering("full", size, step) for size in (1, 2, 4) for step in (1.0, 0.5, 0.25, 0.1))
KEYFRAMES = tuple(
    Rendering("keyframes", size, step, spacing)
    for size in (2, 3, 4)
    for step in (1.0, 0.5, 0.25)
    for spacing in (8.0, 16.0, 32.0, 64.0)
    if step == 0.5 or spacing == 32.0
)
RENDERINGS = (REFERENCE, *FULL, *KEYFRAMES)
"""All renderings, the reference first."""
BEFORE_CLOSEST_S = 0.06
"""The piece begins this long before closest approach, so that it is not symmetric."""
COLUMNS = (
    "rendering",
    "supersampling",
    "step_px",
    "keyframe_px",
    "cpu_ms_per_sample",
    "events_excess",
    *(f"recall_within_{limit}us" for limit in WITHIN_US),
    *(f"precision_within_{limit}us" for limit in WITHIN_US),
    "median_us",
)
"""Columns of a row: the rendering, its cost, the excess of events, recall, precision and median."""


def noise_free_sensor(config: SensorConfig | None) -> SensorConfig:
    """Return `SENSOR` with the thresholds and the mismatch of another sensor; None: its own."""
    if config is None:
        return SENSOR
    thresholds = {name: getattr(config, name) for name in ("theta_on", "theta_off")}
    return replace(SENSOR, **thresholds, theta_mismatch=config.theta_mismatch)


def measure_convergence(
    config: CrossingConfig,
    piece_px: float,
    renderings: Iterable[Rendering],
    sensor: SensorConfig = SENSOR,
) -> Iterator[tuple[Any, ...]]:
    """Render a piece of a crossing in several ways; the first one is the reference.

    Yields:
        The values of `COLUMNS` for each rendering.
    """
    reference: Events | None = None
    for rendering in renderings:
        kind, supersample, step_px, spacing_px = rendering
        events, cpu_ms = piece_events(config, piece_px, rendering, sensor)
        reference = events if reference is None else reference
        found = match(events, reference)
        yield (
            kind,
            supersample,
            step_px,
            spacing_px or "",
            cpu_ms,
            found.excess,
            *found.recall,
            *found.precision,
            found.median_us,
        )


def piece_events(
    config: CrossingConfig, piece_px: float, rendering: Rendering, sensor: SensorConfig = SENSOR
) -> tuple[Events, float]:
    """Return the events of a piece around closest approach, and the cost of rendering it.

    Args:
        config: the crossing; its supersampling and keyframe spacing are replaced.
        piece_px: distance that the vehicle moves [px].
        rendering: how to render the piece.
        sensor: sensor that sees it, of the size of the rendering.

    Returns:
        The events, and the CPU time per sample without what is rendered once [ms].
    """
    kind, supersample, step_px, spacing_px = rendering
    crossing = Crossing(
        replace(config, supersample=supersample, keyframe_px=spacing_px or config.keyframe_px)
    )
    times_us = piece_times_us(crossing, piece_px, step_px)
    render = full_frames if kind == "full" else keyframe_frames
    frames = TimedFrames(render(crossing, times_us))
    events = events_of(frames, sensor)
    return events, 1e3 * frames.spent_s / max(len(times_us) - 1, 1)


class TimedFrames:
    """Frames from an iterator, and the CPU time that all except the first one take.

    Attributes:
        spent_s: CPU time so far [s].
    """

    def __init__(self, frames: Iterator[tuple[int, Luminance]]) -> None:
        self._frames = frames
        self.spent_s = 0.0

    def __iter__(self) -> Iterator[tuple[int, Luminance]]:
        """Yield the frames."""
        yield next(self._frames)
        while True:
            start_s = time.process_time()
            frame = next(self._frames, None)
            if frame is None:
                return
            self.spent_s += time.process_time() - start_s
            yield frame


def events_of(frames: Iterable[tuple[int, Luminance]], config: SensorConfig = SENSOR) -> Events:
    """Return the events of a sensor that has adapted to the first frame."""
    sensor = EventSensor(config, seed=0)
    steps = [sensor.step(t_us, luminance).events for t_us, luminance in frames]
    return np.concatenate(steps[1:])


def piece_times_us(crossing: Crossing, piece_px: float, step_px: float) -> list[int]:
    """Return times of samples between which the target's flank moves by `step_px` [µs]."""
    speed_px_s = target_speed_px_s(crossing)
    first_us = crossing.duration_us // 2 - round(BEFORE_CLOSEST_S * 1e6)
    steps = round(piece_px / step_px)
    return [first_us + round(1e6 * k * step_px / speed_px_s) for k in range(steps + 1)]


def target_speed_px_s(crossing: Crossing) -> float:
    """Return the image speed of the target's flank at closest approach [px/s]."""
    speed_m_s = crossing.scene.trajectory.speed_m_s(0.0)
    return crossing.intrinsics.focal_px * speed_m_s / crossing.config.distance


def full_frames(crossing: Crossing, times_us: list[int]) -> Iterator[tuple[int, Luminance]]:
    """Yield samples that are all rendered in full."""
    with crossing.full_frame_renderer() as draw:
        for t_us in times_us:
            yield t_us, draw(t_us)


def keyframe_frames(crossing: Crossing, times_us: list[int]) -> Iterator[tuple[int, Luminance]]:
    """Yield samples from keyframes, half way between two, where errors are greatest."""
    with crossing.keyframe_renderer(with_keyframe_times_us(crossing, times_us)) as draw:
        for t_us in times_us:
            yield t_us, draw(t_us).luminance


def with_keyframe_times_us(crossing: Crossing, times_us: list[int]) -> list[int]:
    """Return the times with those of two keyframes, before and after, at equal distances."""
    middle_us = (times_us[0] + times_us[-1]) / 2
    offset_us = 1e6 * crossing.config.keyframe_px / 2 / target_speed_px_s(crossing)
    first, last = (round(middle_us + side * offset_us) for side in (-1, 1))
    return [min(first, times_us[0] - 1), *times_us, max(last, times_us[-1] + 1)]
