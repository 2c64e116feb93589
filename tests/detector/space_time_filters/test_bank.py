import math

import numpy as np
import pytest

from detector.space_time_filters.bank import (
    CELL_PX,
    DIRECTIONS,
    FilterBank,
    Normalisation,
    odd_cells,
)
from detector.space_time_filters.filters import (
    SUPPORT,
    biphasic,
    gabor,
    monophasic,
    mu_of_speed,
)
from flybench.direction import Direction
from flybench.events import Events
from tests.detector.stimuli import noise, turned

WIDTH, HEIGHT, END_US = 30, 26, 100_000
SPEEDS_PX_S = np.array([60.0, 240.0])
FREQUENCY, SIGMA = 0.08, 25.0


def bank() -> FilterBank:
    return FilterBank(SPEEDS_PX_S, sigma=SIGMA, frequency=FREQUENCY, width=WIDTH, height=HEIGHT)


def plain_response(events: Events, x: float, y: float, direction: int, mu: float) -> float:
    """Return the response at a point: the sum of the filter over all events (equation 25)."""
    angle = direction * math.pi / 4
    fx, fy = -FREQUENCY * math.cos(angle), -FREQUENCY * math.sin(angle)
    total = 0.0
    for t, ex, ey, p in events.tolist():
        dx, dy = x - (ex // 2 * 2 + 0.5), y - (ey // 2 * 2 + 0.5)  # events lie in their cell
        age = np.array((END_US - t) * 1e-6)
        if age >= SUPPORT * mu:
            continue
        space = complex(gabor(np.array(dx), fx, SIGMA) * gabor(np.array(dy), fy, SIGMA))
        time_odd, time_even = float(monophasic(age, mu)), float(biphasic(age, mu))
        total += (1 if p else -1) * (space.imag * time_odd + space.real * time_even)
    return total


def test_the_responses_equal_a_plain_sum_over_events() -> None:
    events = noise(4.0, duration_us=END_US, width=WIDTH, height=HEIGHT, seed=1)
    found = bank().responses(events, END_US)
    assert found.shape == (2, DIRECTIONS, 7, 8)
    for s, speed_px_s in enumerate(SPEEDS_PX_S):
        mu = mu_of_speed(float(speed_px_s), FREQUENCY)
        for direction in range(DIRECTIONS):
            expected = plain_response(events, 4 * 3 + 0.5, 4 * 2 + 0.5, direction, mu)
            assert found[s, direction, 2, 3] == pytest.approx(expected, abs=3e-4)


def test_mirrored_events_give_mirrored_responses() -> None:
    events = noise(20.0, duration_us=END_US, width=WIDTH, height=HEIGHT, seed=2)
    found = bank().responses(events, END_US)
    mirrored = turned(events, Direction.LEFT, width=WIDTH, height=HEIGHT)
    opposite = bank().responses(mirrored, END_US)[:, [4, 3, 2, 1, 0, 7, 6, 5], :, ::-1]
    np.testing.assert_allclose(found, opposite, atol=1e-5)


@pytest.mark.parametrize(("size_px", "cells"), [(346, 173), (260, 129), (2, 1), (5, 1), (6, 3)])
def test_the_number_of_cells_is_odd(size_px: int, cells: int) -> None:
    assert odd_cells(size_px) == cells
    assert cells * CELL_PX <= size_px


def normalisation(alpha_q: float = 0.002) -> Normalisation:
    return Normalisation(beta=1.0, alpha_p=0.1, alpha_q=alpha_q, sigma_px=3.6, shape=(21, 21))


def test_the_normalisation_is_the_papers_equation_31() -> None:
    responses = np.full((2, DIRECTIONS, 21, 21), 0.02, np.float32)
    responses[:, 4:] = -0.02
    found = normalisation()(responses)
    expected = 0.02 / (0.1 + 0.02 + 0.01 / 0.002)  # half of the pool is not active
    assert found[0, 0, 10, 10] == pytest.approx(expected, rel=1e-3)
    assert (found[:, 4:] == 0.0).all()


def test_the_normalisation_makes_strong_and_weak_contrast_alike() -> None:
    responses = np.zeros((1, DIRECTIONS, 21, 21), np.float32)
    responses[:, 0] = 1.0
    weak, strong = (normalisation()(responses * scale)[0, 0, 10, 10] for scale in (0.1, 1.0))
    assert strong / weak < 1.2
