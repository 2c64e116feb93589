"""Run a crossing through sensor and detector, step by step."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from detector.estimate import Detector, MotionEstimate
from detector.fly.detector import FlyDetector
from emulator import EventSensor, SensorOutput
from emulator.sensor import sensor_bytes
from flybench.memory import check_memory
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.scoring import TargetTrack
from scenarios.pipeline.user_detectors import find_method
from sim import Crossing, GroundTruth, Intrinsics, LuminanceCache, Sample
from sim.render.filament import rendering_bytes


@dataclass(frozen=True)
class Step:
    """Results of one luminance sample.

    Attributes:
        sample: luminance and ground truth.
        output: events and frames of the sensor since the previous sample.
        estimates: estimates of the detector from this output.
    """

    sample: Sample
    output: SensorOutput
    estimates: list[MotionEstimate]


TOTAL = "total"
"""Name of the stage that contains all others."""


class Stopwatch:
    """Wall time by stage [s].

    Attributes:
        wall_s: wall time spent in each stage so far [s].
    """

    def __init__(self) -> None:
        self.wall_s: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Return a context manager that adds the time of its block to stage `name`."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.wall_s[name] = self.wall_s.get(name, 0.0) + time.perf_counter() - start


def make_crossing(config: RunConfig, cache: LuminanceCache | None = None) -> Crossing:
    """Return the crossing of `config`, as its sensor and lens see it.

    Args:
        config: configuration of the run.
        cache: cache for rendered luminance; None: no cache.
    """
    sensor = config.sensor
    intrinsics = Intrinsics(sensor.width, sensor.height, sensor.focal_length_px)
    return Crossing(config.crossing, intrinsics, cache=cache)


def make_detector(config: RunConfig) -> Detector:
    """Return a fresh detector for the method and the sensor size of `config`.

    Raises:
        MethodError: the method does not exist, or does not follow the protocol.
    """
    size = {"width": config.sensor.width, "height": config.sensor.height}
    if config.fly is not None:
        return FlyDetector(config.fly, **size)
    return find_method(config.method).make(**size)


def make_feed(config: RunConfig) -> DetectorFeed:
    """Return a fresh detector for the method and the sensor of `config`, ready to be fed.

    Raises:
        MethodError: the method does not exist, or does not follow the protocol.
    """
    sensor = config.sensor
    detector = make_detector(config)
    return DetectorFeed(config.method, detector, width=sensor.width, height=sensor.height)


def check_run_memory(config: RunConfig) -> None:
    """Refuse a run whose scene, sensor and detector do not fit into memory together.

    Raises:
        MemoryBudgetError: they do not fit into the memory budget.
        MethodError: the detector does not exist, or does not follow the protocol.
    """
    detector, sensor = make_detector(config), config.sensor
    intrinsics = Intrinsics(sensor.width, sensor.height, sensor.focal_length_px)
    needed = sensor_bytes(sensor) + rendering_bytes(intrinsics, config.crossing.supersample)
    what = f"Rendering and emulation of {sensor.width}×{sensor.height} px"
    check_memory(what, needed)
    del detector  # counted until here


def add_truth(track: TargetTrack, truth: GroundTruth) -> None:
    """Add the target's position in a sample to a track."""
    centroid = truth.centroid_px
    point = None if centroid is None else (float(centroid[0]), float(centroid[1]))
    track.add(truth.t_us, truth.bounding_box_px, point)


def run_steps(
    config: RunConfig,
    crossing: Crossing,
    feed: DetectorFeed,
    watch: Stopwatch,
    record: Callable[[Sample, SensorOutput], None] = lambda _sample, _output: None,
) -> Iterator[Step]:
    """Render, emulate, record and detect, sample by sample.

    Args:
        config: configuration of the run.
        crossing: scene of the run.
        feed: fresh detector; if it fails, the steps after that have no estimates.
        watch: stopwatch that takes the time of the stages "render", "emulate", "record" and
            "detect".
        record: function that writes the output of the sensor, before the detector sees it.

    Yields:
        One step per sample, in order of time.
    """
    sensor = EventSensor(config.sensor, seed=config.seed)
    samples = crossing.samples()
    while True:
        with watch.stage("render"):
            sample = next(samples, None)
        if sample is None:
            return
        with watch.stage("emulate"):
            output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
        with watch.stage("record"):
            record(sample, output)
        with watch.stage("detect"):
            estimates = feed.feed(output.events, until_us=sample.t_us + 1, frames=output.aps_frames)
        yield Step(sample, output, estimates)
