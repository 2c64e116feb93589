"""One sequence of the study: it is rendered once, and seen by the sensor of every seed."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import cv2

from emulator import SensorConfig
from scenarios.options.cache import CacheOptions
from scenarios.pipeline.registry import is_fly
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_crossing
from scenarios.recording import SequenceRecorder
from scenarios.study.evaluation import SequenceEvaluation
from scenarios.study.results import SequenceResult
from scenarios.study.timed_detector import (
    CONTRAST_HOP_US,
    TimedDetector,
    make_timed_detector,
    warm_up,
)
from sim import Crossing, CrossingConfig

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
    """

    crossing: CrossingConfig
    methods: tuple[str, ...]
    seeds: tuple[int, ...]
    sensor: SensorConfig = field(default_factory=SensorConfig)
    cache: CacheOptions = field(default_factory=CacheOptions)
    contrast_hop_us: int = CONTRAST_HOP_US
    recording: Path | None = None

    @property
    def name(self) -> str:
        """Lighting and angular velocity; see `SequenceResult.name`."""
        return f"{self.crossing.lighting}_{self.crossing.omega_rad_s:.2f}"

    def config(self) -> RunConfig:
        """Return the configuration of a single run with the first seed and the first method."""
        return RunConfig(self.crossing, self.sensor, method=self.methods[0], seed=self.seeds[0])

    def detectors(self, seed: int) -> list[TimedDetector]:
        """Return fresh detectors of all methods, for the sensor of a seed."""
        size = {"width": self.sensor.width, "height": self.sensor.height}
        return [
            make_timed_detector(method, seed, contrast_hop_us=self.contrast_hop_us, **size)
            for method in self.methods
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
    begun_us = _render_ahead(crossing, progress)
    with ExitStack() as stack:
        recorder = None
        if task.recording is not None:
            recorder = stack.enter_context(_recorder(task, task.recording, crossing))
        evaluation = SequenceEvaluation(
            task.crossing,
            task.sensor,
            {seed: task.detectors(seed) for seed in task.seeds},
            recorder,
        )
        for sample in crossing.samples():
            evaluation.add(sample)
            progress(begun_us + sample.t_us, begun_us + crossing.duration_us)
        evaluation.finish()
    return evaluation.result(crossing)


def _render_ahead(crossing: Crossing, progress: Progress) -> int:
    """Fill the cache before the sensors exist, since renderer and sensors both need much memory.

    Returns:
        Time rendered [µs]; 0 if the cache had everything, or there is no cache.
    """
    rendered_us = 0
    for rendered_us in crossing.render_ahead():
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
        name=f"{c.lighting} {c.omega_rad_s:.2f}",
        one_of_several=True,
    )


@lru_cache
def _compile(methods: tuple[str, ...], width: int, height: int, contrast_hop_us: int) -> None:
    """Warm up all methods, once for each process."""
    for method in methods:
        detector = make_timed_detector(
            method, 0, width=width, height=height, contrast_hop_us=contrast_hop_us
        )
        warm_up(detector, width=width, height=height)
