"""Trials that every event-based rival of the fly passes: drawn motion and noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from detector.estimate import Detector, MotionEstimate
from flybench.direction import Direction
from flybench.events import EVENT_DTYPE, Events
from tests.detector.stimuli import (
    HEIGHT,
    WIDTH,
    hot_pixels,
    merged,
    noise,
    size_before_turning,
    slide,
    turned,
)
from tests.detector.test_operating_range import passing, share_with

Maker = Callable[[], Detector]
SETTLED_US, END_US = 100_000, 300_000


def settled(detector: Detector, events: Events, until_us: int) -> list[MotionEstimate]:
    """Return the estimates after the first 100 ms."""
    found = detector.push(events) + detector.advance(until_us)
    return [e for e in found if e.t_us > SETTLED_US]


def share_right(make: Maker, speed_px_s: float, direction: Direction, noise_hz: float) -> float:
    """Return the share of right steps on a passing textured box."""
    events, until_us = passing(speed_px_s, direction, noise_hz=noise_hz)
    events = events[events["t"] < END_US]
    return share_with(settled(make(), events, min(until_us, END_US)), direction)


def bar(speed_px_s: float, direction: Direction) -> tuple[Events, int]:
    """Return the events and duration of a dark bar of 10×80 px, in noise of 1 Hz per pixel."""
    width, height = size_before_turning(direction)
    duration_us = int(min(0.5, width / speed_px_s) * 1e6)
    rightward = slide(
        np.full((80, 10), -0.9),
        speed_px_s=speed_px_s,
        start_px=(width - speed_px_s * duration_us * 1e-6) / 2,
        top_px=(height - 80) // 2,
        duration_us=duration_us,
        background=np.zeros((height, width)),
        seed=int(speed_px_s),
    )
    events = turned(rightward, direction, width=width, height=height)
    return merged(events, noise(1.0, duration_us=duration_us, seed=3)), duration_us


def share_right_on_bar(make: Maker, speed_px_s: float, direction: Direction) -> float:
    """Return the share of right steps on a moving bar."""
    events, until_us = bar(speed_px_s, direction)
    return share_with(settled(make(), events, until_us), direction)


def share_none_in_noise(make: Maker, rate_hz: float) -> float:
    """Return the share of steps without a direction in noise with hot pixels."""
    until_us = END_US
    events = merged(
        noise(rate_hz, duration_us=until_us, seed=7),
        hot_pixels(20, 50, duration_us=until_us, seed=8),
    )
    return share_with(settled(make(), events, until_us), Direction.NONE)


def assert_cuts_change_nothing(make: Maker) -> None:
    """Check that cuts between chunks and calls of `advance` change no estimate."""
    events, until_us = passing(620, Direction.RIGHT, noise_hz=1.0)
    events, until_us = events[events["t"] < 150_000], 150_000
    one, many = make(), make()
    whole = one.push(events) + one.advance(until_us)
    pieces = []
    for start in range(0, events.size, 1501):
        piece = events[start : start + 1501]
        pieces += many.push(piece) + many.advance(int(piece["t"][-1]))
    assert pieces + many.advance(until_us) == whole


def assert_a_late_start_changes_nothing(make: Maker) -> None:
    """Check that a stream that starts late gives the same estimates."""
    events, _ = passing(300, Direction.RIGHT, noise_hz=0.0)
    events = events[events["t"] < 100_000]
    found, late = make().push(events), make()
    events["t"] += 10**15
    later = [replace(e, t_us=e.t_us - 10**15) for e in late.push(events)]
    assert later == found


def assert_many_events_at_one_time_are_survived(make: Maker) -> None:
    """Check the estimates after ten events of every pixel at the same time."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    events = np.zeros((10, HEIGHT, WIDTH), EVENT_DTYPE)
    events["t"], events["x"], events["y"], events["p"] = 5_000, columns, rows, True
    detector = make()
    found = detector.push(events.ravel()) + detector.advance(200_000)
    assert len(found) == 20
    assert found[-1].direction is Direction.NONE
