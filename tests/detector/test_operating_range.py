"""How fast and how noisy: each preset inside the range that it states.

The textures, places and noise are other than those on which the parameters were chosen.
"""

import numpy as np
import pytest

from detector.estimate import Direction, MotionEstimate
from detector.fly import FlyConfig, FlyDetector
from detector.metrics import grms
from emulator.events import Events
from tests.detector.stimuli import (
    HEIGHT,
    WIDTH,
    asphalt,
    crossing,
    merged,
    noise,
    slide,
    textured_box,
    turned,
)

MOVING = [d for d in Direction if d is not Direction.NONE]
LENGTH_PX = 120


def passing(speed_px_s: float, direction: Direction, *, noise_hz: float) -> tuple[Events, int]:
    """A textured box that passes: whole where it is fast, its middle part where it is slow."""
    upright = direction in (Direction.RIGHT, Direction.LEFT)
    width, height = (WIDTH, HEIGHT) if upright else (HEIGHT, WIDTH)
    seconds = min(0.8, (width + LENGTH_PX) / speed_px_s)
    duration_us, seed = int(seconds * 1e6), 1000 + int(speed_px_s)
    events = slide(
        textured_box(LENGTH_PX, 50, seed=seed),
        speed_px_s=speed_px_s,
        start_px=(width - LENGTH_PX - speed_px_s * seconds) / 2,
        top_px=height // 2 - 40,
        duration_us=duration_us,
        background=asphalt(height, width, seed=seed),
        seed=seed,
    )
    events = turned(events, direction, width=width, height=height)
    return merged(events, noise(noise_hz, duration_us=duration_us, seed=seed)), duration_us


def after_100_ms(preset: str, events: Events, until_us: int) -> list[MotionEstimate]:
    fly = FlyDetector(FlyConfig.preset(preset))
    return [e for e in fly.push(events) + fly.advance(until_us) if e.t_us > 100_000]


def share(found: list[MotionEstimate], direction: Direction) -> float:
    return float(np.mean([e.direction is direction for e in found]))


@pytest.mark.parametrize("noise_hz", [0.0, 10.0])
@pytest.mark.parametrize("direction", MOVING)
@pytest.mark.parametrize("speed_px_s", [60, 130, 300, 620, 1000, 1500])
def test_wide_is_right_from_60_to_1500_px_s(
    speed_px_s: float, direction: Direction, noise_hz: float
) -> None:
    events, duration_us = passing(speed_px_s, direction, noise_hz=noise_hz)
    assert share(after_100_ms("wide", events, duration_us), direction) >= 0.95


@pytest.mark.parametrize("direction", MOVING)
@pytest.mark.parametrize("speed_px_s", [300, 620, 960])
def test_wide_is_no_worse_where_the_paper_preset_is_at_home(
    speed_px_s: float, direction: Direction
) -> None:
    events, duration_us = passing(speed_px_s, direction, noise_hz=5.0)
    paper, wide = (
        share(after_100_ms(preset, events, duration_us), direction) for preset in ("paper", "wide")
    )
    assert paper >= 0.9
    assert wide >= paper - 0.01


@pytest.mark.parametrize("direction", MOVING)
@pytest.mark.parametrize("speed_px_s", [40, 90])
def test_below_its_range_the_paper_preset_says_none_and_not_the_opposite(
    speed_px_s: float, direction: Direction
) -> None:
    events, duration_us = passing(speed_px_s, direction, noise_hz=1.0)
    found = after_100_ms("paper", events, duration_us)
    assert share(found, direction) + share(found, Direction.NONE) >= 0.95


@pytest.mark.parametrize("preset", ["paper", "wide"])
def test_the_floor_costs_less_than_a_point_on_what_moves(preset: str) -> None:
    with_floor, without = [], []
    for speed_px_s in (300, 500, 900):
        for direction in MOVING:
            events, duration_us = passing(speed_px_s, direction, noise_hz=3.0)
            found = after_100_ms(preset, events, duration_us)
            strongest = [
                (Direction.RIGHT if e.hs > 0 else Direction.LEFT)
                if abs(e.hs) >= abs(e.vs)
                else (Direction.DOWN if e.vs > 0 else Direction.UP)
                for e in found
            ]
            with_floor.append(share(found, direction))
            without.append(np.mean([s is direction for s in strongest]))
    assert np.mean(without) - np.mean(with_floor) < 0.01


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
