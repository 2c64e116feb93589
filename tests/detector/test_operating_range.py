"""The operating range in speed and noise that each preset states.

Textures, positions and noise differ from those on which the parameters were chosen.
"""

from functools import lru_cache

import numpy as np
import pytest

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyConfig, FlyDetector
from detector.metrics import grms
from flybench.direction import CARDINAL, Direction
from flybench.events import Events
from tests.detector.stimuli import (
    asphalt,
    crossing,
    merged,
    noise,
    size_before_turning,
    slide,
    textured_box,
    turned,
)

LENGTH_PX = 120
PAPER_SPEEDS_PX_S = (300, 620, 960)


def passing(speed_px_s: float, direction: Direction, *, noise_hz: float) -> tuple[Events, int]:
    """Return the events and duration of a passing textured box.

    A fast box crosses the whole view, a slow one the middle part.
    """
    width, height = size_before_turning(direction)
    rightward, duration_us = _rightward(speed_px_s, width, height)
    events = turned(rightward, direction, width=width, height=height)
    return merged(
        events, noise(noise_hz, duration_us=duration_us, seed=_seed(speed_px_s))
    ), duration_us


def _seed(speed_px_s: float) -> int:
    return 1000 + int(speed_px_s)


@lru_cache(maxsize=64)
def _rightward(speed_px_s: float, width: int, height: int) -> tuple[Events, int]:
    seconds = min(0.8, (width + LENGTH_PX) / speed_px_s)
    duration_us, seed = int(seconds * 1e6), _seed(speed_px_s)
    events = slide(
        textured_box(LENGTH_PX, 50, seed=seed),
        speed_px_s=speed_px_s,
        start_px=(width - LENGTH_PX - speed_px_s * seconds) / 2,
        top_px=height // 2 - 40,
        duration_us=duration_us,
        background=asphalt(height, width, seed=seed),
        seed=seed,
    )
    return events, duration_us


@lru_cache(maxsize=256)
def after_100_ms(
    preset: str, speed_px_s: float, direction: Direction, noise_hz: float
) -> list[MotionEstimate]:
    events, until_us = passing(speed_px_s, direction, noise_hz=noise_hz)
    fly = FlyDetector(FlyConfig.preset(preset))
    return [e for e in fly.push(events) + fly.advance(until_us) if e.t_us > 100_000]


def share_with(found: list[MotionEstimate], direction: Direction) -> float:
    return float(np.mean([e.direction is direction for e in found]))


@pytest.mark.parametrize("noise_hz", [0.0, 10.0])
@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("speed_px_s", [60, 130, 300, 620, 1000, 1500])
def test_wide_is_right_from_60_to_1500_px_s(
    speed_px_s: float, direction: Direction, noise_hz: float
) -> None:
    assert share_with(after_100_ms("wide", speed_px_s, direction, noise_hz), direction) >= 0.95


@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("speed_px_s", PAPER_SPEEDS_PX_S)
def test_wide_is_no_worse_in_the_range_of_the_paper_preset(
    speed_px_s: float, direction: Direction
) -> None:
    paper, wide = (
        share_with(after_100_ms(preset, speed_px_s, direction, 5.0), direction)
        for preset in ("paper", "wide")
    )
    assert paper >= 0.9
    assert wide >= paper - 0.01


@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("speed_px_s", [40, 90])
def test_below_its_range_the_paper_preset_gives_none_and_not_the_opposite(
    speed_px_s: float, direction: Direction
) -> None:
    found = after_100_ms("paper", speed_px_s, direction, 1.0)
    assert share_with(found, direction) + share_with(found, Direction.NONE) >= 0.95


@pytest.mark.parametrize("preset", ["paper", "wide"])
def test_the_floors_cost_less_than_a_point_on_moving_targets(preset: str) -> None:
    with_floors, without = [], []
    for speed_px_s in PAPER_SPEEDS_PX_S:
        for direction in CARDINAL:
            found = after_100_ms(preset, speed_px_s, direction, 5.0)
            strongest = [
                (Direction.RIGHT if e.hs > 0 else Direction.LEFT)
                if abs(e.hs) >= abs(e.vs)
                else (Direction.DOWN if e.vs > 0 else Direction.UP)
                for e in found
            ]
            with_floors.append(share_with(found, direction))
            without.append(np.mean([s is direction for s in strongest]))
    assert np.mean(without) - np.mean(with_floors) < 0.01


@pytest.mark.parametrize("direction", [Direction.RIGHT, Direction.UP])
def test_grms_rises_with_speed(direction: Direction) -> None:
    figures = []
    for speed_px_s in (300, 420, 590, 830):
        events, view_us = crossing(
            textured_box(LENGTH_PX, 50, seed=9), speed_px_s=speed_px_s, direction=direction
        )
        fly = FlyDetector()
        found = fly.push(merged(events, noise(1.0, duration_us=view_us))) + fly.advance(view_us)
        figures.append(grms(found, crossing_us=(0, view_us)) or 0.0)
    assert figures == sorted(figures)
    assert figures[-1] > 2.0 * figures[0]
