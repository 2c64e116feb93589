"""Print how often the flies are right within their reach: `python -m tests.detector.fly.reach`.

Every drawn target has a shape, a direction, a tilt of 0 to 35°, a speed of 60 to 1500 px/s, one to
five events an edge and a noise of 0 to 10 Hz per pixel, all drawn at random. No parameter was
chosen on these shapes and seeds. Of a bar, little but the motion normal to its long edges can be
seen; at these tilts it is in the same one of the four directions, so that it counts as right.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np

from detector.estimate import MotionEstimate
from detector.fly.config import FlyConfig
from detector.fly.detector import FlyDetector
from flybench.direction import CARDINAL, Direction
from flybench.events import Events
from tests.detector.drawn_shapes import moving_shape
from tests.detector.stimuli import HEIGHT, WIDTH

SHAPES = ("ellipse", "triangle", "frame", "bar")
SPEEDS_PX_S, MOST_TILT_DEG, MOST_EVENTS, MOST_NOISE_HZ = (60.0, 1500.0), 35.0, 5, 10.0
SETTLED_US = 100_000
SEED = 2000
"""Seed of the first target."""
NUMBER = 200


def targets(number: int) -> Iterator[tuple[Direction, Events, int]]:
    """Yield the direction, the events and the duration [µs] of targets drawn at random."""
    for n in range(number):
        rng = np.random.default_rng(SEED + n)
        direction = CARDINAL[int(rng.integers(len(CARDINAL)))]
        events, until_us = moving_shape(
            SHAPES[int(rng.integers(len(SHAPES)))],
            direction,
            speed_px_s=float(np.exp(rng.uniform(*np.log(SPEEDS_PX_S)))),
            tilt_deg=float(rng.uniform(-MOST_TILT_DEG, MOST_TILT_DEG)),
            events_per_edge=int(rng.integers(1, MOST_EVENTS + 1)),
            noise_hz=float(rng.uniform(0.0, MOST_NOISE_HZ)),
            seed=SEED + n,
        )
        yield direction, events, until_us


def estimates(
    preset: str, events: Events, until_us: int, *, width: int = WIDTH, height: int = HEIGHT
) -> list[MotionEstimate]:
    """Return the estimates of a fresh fly."""
    fly = FlyDetector(FlyConfig.preset(preset), width=width, height=height)
    return fly.push(events) + fly.advance(until_us)


def shares(found: list[MotionEstimate], truth: Direction) -> tuple[float, float]:
    """Return the shares of right and of wrong steps after the first 100 ms."""
    named = [e.direction for e in found if e.t_us > SETTLED_US]
    wrong = [d for d in named if d not in (truth, Direction.NONE)]
    return named.count(truth) / len(named), len(wrong) / len(named)


def main() -> None:
    """Print the mean shares of each preset, and the share of right steps of the worst target."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--number", type=int, default=NUMBER, help="number of targets")
    number = parser.parse_args().number
    found: dict[str, list[tuple[float, float]]] = {"paper": [], "wide": [], "robust": []}
    for direction, events, until_us in targets(number):
        for preset, of_preset in found.items():
            of_preset.append(shares(estimates(preset, events, until_us), direction))
    for preset, of_preset in found.items():
        right, wrong = np.mean(of_preset, axis=0)
        print(
            f"{preset}: {right:.1%} right, {wrong:.1%} wrong, {1 - right - wrong:.1%} none; of the "
            f"worst target, {min(of_preset)[0]:.0%} right"
        )


if __name__ == "__main__":
    main()
