"""Peaks that are no motion."""

import numpy as np
import pytest

from detector.contrast_maximisation.detector import ContrastConfig, maximise_contrast
from flybench.events import Events
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
