"""One rendering, seen by many sensors: the light is the same for all seeds, the noise is not."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from detector.estimate import MotionEstimate
from emulator import EventSensor
from scenarios.pipeline.feeding import feed
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_detector, note
from scenarios.pipeline.scoring import Track
from scenarios.pipeline.summary import EventTally
from sim import Sample


@dataclass
class Seen:
    """What one run saw and said.

    Attributes:
        tally: its sensor's events.
        estimates: all that its detector said.
    """

    tally: EventTally
    estimates: list[MotionEstimate] = field(default_factory=list)


def run_side_by_side(
    configs: Sequence[RunConfig],
    samples: Iterable[Sample],
    progress: Callable[[int], None] = lambda _t_us: None,
) -> tuple[list[Seen], Track]:
    """Show the same light to the sensor and the detector of every run, all side by side.

    No more than one sample is held, so that a rendering, a cache or drawn light will do alike.
    Runs whose sensors are the same, with the same seed, share one.

    Args:
        configs: runs, whose crossings are not looked at.
        samples: the light, in order of time.
        progress: told the time reached [µs].

    Returns:
        What each run saw, and where the target was.
    """
    sensors = {(c.sensor, c.seed): EventSensor(c.sensor, seed=c.seed) for c in configs}
    tallies = {key: EventTally() for key in sensors}
    seen = [Seen(tallies[c.sensor, c.seed]) for c in configs]
    detectors = [make_detector(config) for config in configs]
    track = Track()
    for sample in samples:
        note(track, sample.truth)
        outputs = {
            key: sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
            for key, sensor in sensors.items()
        }
        for key, output in outputs.items():
            tallies[key].add(output)
        for config, detector, one in zip(configs, detectors, seen, strict=True):
            output = outputs[config.sensor, config.seed]
            one.estimates += feed(
                detector,
                output.events,
                until_us=sample.t_us + 1,
                frames=output.aps_frames,
                said=one.estimates,
            )
        progress(sample.t_us)
    return seen, track


def run_repeats(
    config: RunConfig,
    samples: Iterable[Sample],
    seeds: Sequence[int],
    progress: Callable[[int], None] = lambda _t_us: None,
) -> tuple[list[list[MotionEstimate]], Track]:
    """Show the same light to one sensor and one detector a seed; see `run_side_by_side`.

    Args:
        config: sensor and detector; its own seed is not used.
        samples: the light, in order of time.
        seeds: of the sensors.
        progress: told the time reached [µs].

    Returns:
        Estimates by seed, and where the target was.
    """
    runs = [replace(config, seed=seed) for seed in seeds]
    seen, track = run_side_by_side(runs, samples, progress)
    return [one.estimates for one in seen], track
