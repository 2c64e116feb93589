"""Show one rendered sequence to many sensors, whose noise differs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from detector.estimate import MotionEstimate
from emulator import EventSensor
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import add_truth, make_feed
from scenarios.pipeline.scoring import TargetTrack
from scenarios.pipeline.summary import EventTally
from sim import Sample


@dataclass
class RunResult:
    """Result of one run.

    Attributes:
        tally: counts of the sensor's events.
        feed: the detector; see `DetectorFeed.failure`.
        estimates: all estimates of the detector, until it failed.
    """

    tally: EventTally
    feed: DetectorFeed
    estimates: list[MotionEstimate] = field(default_factory=list)


def run_side_by_side(
    configs: Sequence[RunConfig],
    samples: Iterable[Sample],
    progress: Callable[[int], None] = lambda _t_us: None,
) -> tuple[list[RunResult], TargetTrack]:
    """Show the same luminance to the sensor and detector of every run, side by side.

    Only one sample is held in memory at a time, so that samples may come from the renderer, from
    the cache or from a synthetic stimulus. Runs with equal sensors and seeds share one sensor.

    Args:
        configs: configurations of the runs; their crossings are ignored.
        samples: luminance samples, in order of time.
        progress: function that is called with the time reached [µs].

    Returns:
        The result of each run, and the track of the target. If a detector fails, the others go on;
        if all have failed, the rest of the samples is left out.
    """
    sensors = {(c.sensor, c.seed): EventSensor(c.sensor, seed=c.seed) for c in configs}
    tallies = {key: EventTally() for key in sensors}
    results = [RunResult(tallies[c.sensor, c.seed], make_feed(c)) for c in configs]
    track = TargetTrack()
    for sample in samples:
        add_truth(track, sample.truth)
        outputs = {
            key: sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
            for key, sensor in sensors.items()
        }
        for key, output in outputs.items():
            tallies[key].add(output)
        for config, result in zip(configs, results, strict=True):
            output = outputs[config.sensor, config.seed]
            result.estimates += result.feed.feed(
                output.events, until_us=sample.t_us + 1, frames=output.aps_frames
            )
        progress(sample.t_us)
        if all(result.feed.failure for result in results):
            break
    return results, track


def run_repeats(
    config: RunConfig,
    samples: Iterable[Sample],
    seeds: Sequence[int],
    progress: Callable[[int], None] = lambda _t_us: None,
) -> tuple[list[list[MotionEstimate]], TargetTrack]:
    """Show the same luminance to one sensor and detector per seed; see `run_side_by_side`.

    Args:
        config: configuration of sensor and detector; its own seed is ignored.
        samples: luminance samples, in order of time.
        seeds: seeds of the sensors.
        progress: function that is called with the time reached [µs].

    Returns:
        The estimates for each seed, and the track of the target.

    Raises:
        MethodError: the detector failed.
    """
    runs = [replace(config, seed=seed) for seed in seeds]
    results, track = run_side_by_side(runs, samples, progress)
    for result in results:
        result.feed.raise_failure()
    return [result.estimates for result in results], track
