"""Which peak of the reward is the motion, and which are none."""

import numpy as np
import pytest

from detector.contrast_maximisation.detector import (
    ContrastConfig,
    ContrastMaximisation,
    maximise_contrast,
)
from flybench.direction import Direction
from flybench.events import Events
from tests.detector.drawn_shapes import moving_shape
from tests.detector.stimuli import HEIGHT, WIDTH, merged, noise

WINDOW_US = 50_000


def bursts_of_noise(number: int, *, rate_hz: float, seed: int) -> Events:
    """Return noise in which every event is followed by others of its pixel within a few ms."""
    first, rng = noise(rate_hz, duration_us=WINDOW_US, seed=seed), np.random.default_rng(seed)
    parts = [first]
    for n in range(1, number):
        parts.append(first.copy())
        parts[-1]["t"] += n * rng.integers(1, 1000, first.size)
    events = merged(*parts)
    return events[events["t"] < WINDOW_US]


@pytest.mark.parametrize("number", [2, 3, 5])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_bursts_of_noise_are_no_motion(number: int, seed: int) -> None:
    events = bursts_of_noise(number, rate_hz=0.5, seed=seed)
    found = maximise_contrast(events, from_us=0, to_us=WINDOW_US, width=WIDTH, height=HEIGHT)
    assert found is not None
    assert found.prominence < ContrastConfig().prominence_floor


@pytest.mark.parametrize(("tilt_deg", "speed_px_s"), [(14, 80), (16, 70), (19, 75)])
@pytest.mark.parametrize("direction", [Direction.RIGHT, Direction.UP])
def test_the_slowest_of_equally_sharp_velocities_is_chosen(
    tilt_deg: float, speed_px_s: float, direction: Direction
) -> None:
    """A straight edge is as sharp at any velocity along it: a fast sideways one, for example."""
    events, until_us = moving_shape(
        "bar", direction, speed_px_s=speed_px_s, tilt_deg=tilt_deg, events_per_edge=1, seed=7
    )
    detector = ContrastMaximisation(width=WIDTH, height=HEIGHT)
    found = detector.push(events) + detector.advance(until_us)
    assert {e.direction for e in found if e.t_us > 100_000} == {direction}
    speeds = [np.hypot(*e.response) for e in found if e.t_us > 100_000]
    assert np.median(speeds) == pytest.approx(speed_px_s, rel=0.1)
