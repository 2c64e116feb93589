"""One sequence of the study: it is rendered once, and seen by the sensor of every seed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import cv2

from emulator import SensorConfig
from scenarios.options.cache import CacheOptions
from scenarios.pipeline.registry import is_fly, study_sensors
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_crossing
from scenarios.recording import SequenceRecorder
from scenarios.study.conditions import HIGH_THRESHOLDS, SECTION_US, high_thresholds
from scenarios.study.evaluation import SequenceEvaluation
from scenarios.study.results import DEFAULT_SENSOR, STILL, SequenceResult, sequence_name
from scenarios.study.timed_detector import (
    CONTRAST_HOP_US,
    TimedDetector,
    make_timed_detector,
    warm_up,
)
from sim import Crossing, CrossingConfig

PREVIEW_PERIOD_US = 100_000
"""Time between the colour previews of a recording [µs]. For a shaking camera each is a whole
rendered image (0.15 s of CPU by day, 0.22 s at night), so that a study has half as many as a single
run (assumed)."""
Progress = Callable[[int, int], None]
"""Called with the time reached and the whole duration [µs]."""


@dataclass(frozen=True)
class SequenceTask:
    """One crossing to run, with its sensors and methods.

    Attributes:
        crossing: scene and motion.
        methods: names of the methods.
        seeds: seeds of the sensors.
        sensor: configuration of the sensors.
        cache: cache of rendered luminance.
        contrast_hop_us: time between the windows of contrast maximisation [µs].
        recording: Rerun file for the first seed; None for no recording.
        background: what moves in the background; then only the middle of the crossing is drawn.
        high_threshold_seeds: seeds of the sensors with high thresholds, which see the same
            luminance.
    """

    crossing: CrossingConfig
    methods: tuple[str, ...]
    seeds: tuple[int, ...]
    sensor: SensorConfig = field(default_factory=SensorConfig)
    cache: CacheOptions = field(default_factory=CacheOptions)
    contrast_hop_us: int = CONTRAST_HOP_US
    recording: Path | None = None
    background: str = STILL
    high_threshold_seeds: tuple[int, ...] = ()

    @property
    def name(self) -> str:
        """Name of the sequence; see `sequence_name`."""
        c = self.crossing
        return sequence_name(c.lighting.value, c.omega_rad_s, self.background)

    @property
    def sensors(self) -> dict[str, SensorConfig]:
        """Configurations of the sensors by name."""
        return {DEFAULT_SENSOR: self.sensor, HIGH_THRESHOLDS: high_thresholds(self.sensor)}

    def all_detectors(self) -> dict[tuple[str, int], list[TimedDetector]]:
        """Return fresh detectors for every sensor, by its name and seed."""
        keys = [(DEFAULT_SENSOR, seed) for seed in self.seeds]
        keys += [(HIGH_THRESHOLDS, seed) for seed in self.high_threshold_seeds]
        return {(name, seed): self.detectors(seed, name) for name, seed in keys}

    def config(self) -> RunConfig:
        """Return the configuration of a single run with the first seed and the first method."""
        return RunConfig(self.crossing, self.sensor, method=self.methods[0], seed=self.seeds[0])

    def detectors(self, seed: int, sensor: str = DEFAULT_SENSOR) -> list[TimedDetector]:
        """Return fresh detectors for a sensor: all methods, but slow ones for few seeds."""
        size = {"width": self.sensor.width, "height": self.sensor.height}
        return [
            make_timed_detector(
                method, seed, contrast_hop_us=self.contrast_hop_us, sensor=sensor, **size
            )
            for method in self.methods
            if self.seeds.index(seed) < study_sensors(method)
        ]


def evaluate_crossing(
    task: SequenceTask, progress: Progress = lambda _done, _all: None
) -> SequenceResult:
    """Run one sequence.

    Args:
        task: crossing, sensors and methods.
        progress: called after every sample.

    Raises:
        RendererError: this machine cannot render.
        OSError: the recording cannot be written.
    """
    cv2.setNumThreads(1)  # the other cores run other sequences
    _compile(task.methods, task.sensor.width, task.sensor.height, task.contrast_hop_us)
    crossing = make_crossing(task.config(), task.cache.open())
    times_us = _times_us(task, crossing)
    begun_us = _render_ahead(crossing, times_us, progress)
    with ExitStack() as stack:
        recorder = None
        if task.recording is not None:
            recorder = stack.enter_context(_recorder(task, task.recording, crossing))
        evaluation = SequenceEvaluation(
            task.crossing,
            task.sensors,
            task.all_detectors(),
            recorder,
            background=task.background,
        )
        for sample in crossing.samples(times_us):
            evaluation.add(sample)
            progress(begun_us + sample.t_us, begun_us + crossing.duration_us)
        evaluation.finish()
    return evaluation.result(crossing)


def _times_us(task: SequenceTask, crossing: Crossing) -> list[int]:
    """Return the times of the samples: all, or those of the middle if the background moves."""
    times_us = crossing.times_us()
    if task.background == STILL:
        return times_us
    middle_us = crossing.duration_us / 2
    return [t_us for t_us in times_us if abs(t_us - middle_us) <= SECTION_US / 2]


def _render_ahead(crossing: Crossing, times_us: Sequence[int], progress: Progress) -> int:
    """Fill the cache before the sensors exist, since renderer and sensors both need much memory.

    Returns:
        Time rendered [µs]; 0 if the cache had everything, or there is no cache.
    """
    rendered_us = 0
    for rendered_us in crossing.render_ahead(times_us):
        progress(rendered_us, 2 * crossing.duration_us)
    return rendered_us


def _recorder(task: SequenceTask, path: Path, crossing: Crossing) -> SequenceRecorder:
    c = task.crossing
    parameters = {
        name: value for name, value in task.config().parameters().items() if name != "method"
    }
    return SequenceRecorder(
        path,
        crossing=crossing,
        parameters=parameters | {"methods": ", ".join(task.methods)},
        methods=task.methods,
        maps_of=next((method for method in task.methods if is_fly(method)), None),
        name=f"{c.lighting} {c.omega_rad_s:.2f} rad/s",
        one_of_several=True,
        preview_period_us=PREVIEW_PERIOD_US,
    )


@lru_cache
def _compile(methods: tuple[str, ...], width: int, height: int, contrast_hop_us: int) -> None:
    """Warm up all methods, once for each process."""
    for method in methods:
        detector = make_timed_detector(
            method, 0, width=width, height=height, contrast_hop_us=contrast_hop_us
        )
        warm_up(detector, width=width, height=height)
