"""Synthetic windows of events that move at a known velocity."""

from __future__ import annotations

import numpy as np

from flybench.direction import Direction
from flybench.events import EVENT_DTYPE, Events
from tests.detector.stimuli import HEIGHT, WIDTH, asphalt, slide, textured_box, turned

WINDOW_US = 50_000


def dots(
    velocity_px_s: tuple[float, float], *, number: int = 2000, events_each: int = 10, seed: int = 0
) -> Events:
    """Return events of moving points that fire at random times of a window, at their position."""
    rng = np.random.default_rng(seed)
    middle = rng.uniform((100, 80), (246, 180), (number, 1, 2))
    t_s = rng.uniform(-0.5, 0.5, (number, events_each)) * WINDOW_US * 1e-6
    at = np.floor(middle + t_s[..., None] * velocity_px_s).reshape(-1, 2)
    events = np.zeros(number * events_each, EVENT_DTYPE)
    events["t"] = ((t_s.ravel() * 1e6) + WINDOW_US / 2).astype(np.int64)
    events["x"], events["y"] = at.T
    events["p"] = rng.random(events.size) < 0.5
    events = events[np.argsort(events["t"], kind="stable")]
    inside = (at[:, 0] >= 0) & (at[:, 0] < WIDTH) & (at[:, 1] >= 0) & (at[:, 1] < HEIGHT)
    assert inside.all()
    return events


def texture(speed_px_s: float, direction: Direction, *, most: int, seed: int = 0) -> Events:
    """Return a window of events of a moving textured box in front of asphalt.

    If there are more than `most` events, a random selection of that many is returned.
    """
    upright = direction in (Direction.RIGHT, Direction.LEFT)
    width, height = (WIDTH, HEIGHT) if upright else (HEIGHT, WIDTH)
    lead_us = max(10_000, int(2 / speed_px_s * 1e6))  # excludes the onset at time 0
    events = slide(
        textured_box(200, 120, seed=seed),
        speed_px_s=speed_px_s,
        start_px=(width - 200) / 2 - speed_px_s * (lead_us + WINDOW_US / 2) * 1e-6,
        top_px=(height - 120) // 2,
        duration_us=WINDOW_US + lead_us,
        background=asphalt(height, width, seed=seed + 1),
        seed=seed,
    )
    events = turned(events[events["t"] >= lead_us], direction, width=width, height=height)
    events["t"] -= lead_us
    if events.size > most:
        chosen = np.random.default_rng(seed).choice(events.size, most, replace=False)
        events = events[np.sort(chosen)]
    return events
