"""Light to decision: a crossing, through the sensor, to the detector, step by step."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from detector.estimate import Detector, MotionEstimate
from detector.fly.detector import FlyDetector
from emulator import EventSensor, SensorOutput
from scenarios.pipeline.feeding import feed
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.scoring import Track
from scenarios.pipeline.user_detectors import find_method
from sim import Crossing, GroundTruth, Intrinsics, LuminanceCache, Sample


@dataclass(frozen=True)
class Step:
    """What one sample of light led to.

    Attributes:
        sample: the light and the truth.
        output: what the sensor said since the sample before.
        estimates: what the detector concluded from it.
    """

    sample: Sample
    output: SensorOutput
    estimates: list[MotionEstimate]


TOTAL = "total"
"""The stage that holds all others."""


class Stopwatch:
    """Wall time by stage [s]."""

    def __init__(self) -> None:
        self.wall_s: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time that the block takes to stage `name`."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.wall_s[name] = self.wall_s.get(name, 0.0) + time.perf_counter() - start


def make_crossing(config: RunConfig, cache: LuminanceCache | None = None) -> Crossing:
    """Return the crossing of `config` as its sensor sees it; rendered luminance goes to `cache`."""
    sensor = config.sensor
    lens = Intrinsics(sensor.width, sensor.height, sensor.focal_length_px)
    return Crossing(config.crossing, lens, cache=cache)


def make_detector(config: RunConfig) -> Detector:
    """A fresh detector of `config`, for a sensor of its size.

    Raises:
        MethodError: there is none of that name, or it does not obey the protocol.
    """
    size = {"width": config.sensor.width, "height": config.sensor.height}
    if config.fly is not None:
        return FlyDetector(config.fly, **size)
    return find_method(config.method).make(**size)


def note(track: Track, truth: GroundTruth) -> None:
    """Take a sample's truth into a track."""
    centroid = truth.centroid_px
    point = None if centroid is None else (float(centroid[0]), float(centroid[1]))
    track.add(truth.t_us, truth.bounding_box_px, point)


def run_steps(
    config: RunConfig, crossing: Crossing, detector: Detector, watch: Stopwatch
) -> Iterator[Step]:
    """Run the stages over a crossing.

    Args:
        config: the run.
        crossing: its scene.
        detector: a fresh one.
        watch: takes the time of stages "render", "emulate" and "detect".

    Yields:
        One step a sample, in order of time.
    """
    sensor = EventSensor(config.sensor, seed=config.seed)
    samples = crossing.samples()
    said: list[MotionEstimate] = []
    while True:
        with watch.stage("render"):
            sample = next(samples, None)
        if sample is None:
            return
        with watch.stage("emulate"):
            output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
        with watch.stage("detect"):
            estimates = feed(
                detector,
                output.events,
                until_us=sample.t_us + 1,
                frames=output.aps_frames,
                said=said,
            )
        said = estimates or said
        yield Step(sample, output, estimates)
