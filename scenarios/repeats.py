"""One rendering, seen by many sensors: the light is the same for all seeds, the noise is not."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from detector.estimate import MotionEstimate
from emulator import Davis346
from scenarios.config import RunConfig
from scenarios.judgement import Track
from scenarios.methods import read
from scenarios.pipeline import make_detector, note
from sim import Sample


def run_repeats(
    config: RunConfig,
    samples: Iterable[Sample],
    seeds: Sequence[int],
    progress: Callable[[int], None] = lambda _t_us: None,
) -> tuple[list[list[MotionEstimate]], Track]:
    """Show the same light to one sensor and one detector a seed, all side by side.

    No more than one sample is held, so that a rendering, a cache or drawn light will do alike.

    Args:
        config: sensor and detector; its own seed is not used.
        samples: the light, in order of time.
        seeds: of the sensors.
        progress: told the time reached [µs].

    Returns:
        Estimates by seed, and where the target was.
    """
    sensors = [Davis346(config.sensor, seed=seed) for seed in seeds]
    detectors = [make_detector(config) for _ in seeds]
    estimates: list[list[MotionEstimate]] = [[] for _ in seeds]
    track = Track()
    for sample in samples:
        note(track, sample.truth)
        for sensor, detector, said in zip(sensors, detectors, estimates, strict=True):
            output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
            until_us = sample.t_us + 1
            said += read(
                detector, output.events, until_us=until_us, frames=output.aps_frames, said=said
            )
        progress(sample.t_us)
    return estimates, track
