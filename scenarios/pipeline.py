"""Light to decision: a crossing, through the sensor, to the fly, step by step."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from detector.estimate import MotionEstimate
from detector.fly import FlyDetector
from emulator import Davis346, SensorOutput
from scenarios.config import RunConfig
from sim import Crossing, GroundTruth, Intrinsics, Sample


@dataclass(frozen=True)
class Step:
    """What one sample of light led to.

    Attributes:
        sample: the light and the truth.
        output: what the sensor said since the sample before.
        estimates: what the fly concluded from it.
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


@dataclass
class ViewSpan:
    """When the target was first and last in view [µs]; empty until it was."""

    first_us: int | None = None
    last_us: int = -1

    def add(self, truth: GroundTruth) -> None:
        """Take the next sample's truth into account."""
        if truth.in_view:
            self.first_us = truth.t_us if self.first_us is None else self.first_us
            self.last_us = truth.t_us

    @property
    def span_us(self) -> tuple[int, int]:
        """First and last time [µs]; (0, 0) where the target never was in view."""
        return (0, 0) if self.first_us is None else (self.first_us, self.last_us)


def make_crossing(config: RunConfig) -> Crossing:
    """The crossing of `config`, seen by a sensor of its size."""
    return Crossing(
        config.crossing, Intrinsics(width=config.sensor.width, height=config.sensor.height)
    )


def make_fly(config: RunConfig) -> FlyDetector:
    """The detector of `config`, for a sensor of its size."""
    return FlyDetector(config.fly, width=config.sensor.width, height=config.sensor.height)


def run_steps(
    config: RunConfig, crossing: Crossing, fly: FlyDetector, watch: Stopwatch
) -> Iterator[Step]:
    """Run the stages over a crossing.

    Args:
        config: the run.
        crossing: its scene.
        fly: the detector, fresh; its maps are those of the last estimate of a step.
        watch: takes the time of stages "render", "emulate" and "detect".

    Yields:
        One step a sample, in order of time.
    """
    sensor = Davis346(config.sensor, seed=config.seed)
    samples = crossing.samples()
    while True:
        with watch.stage("render"):
            sample = next(samples, None)
        if sample is None:
            return
        with watch.stage("emulate"):
            output = sensor.step(sample.t_us, sample.luminance)
        with watch.stage("detect"):
            estimates = fly.push(output.events)
            estimates += fly.advance(sample.t_us + 1)
        yield Step(sample, output, estimates)
