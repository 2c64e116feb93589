"""The default drawing against full drawing, both against a finer one: by events."""

from typing import Any

import numpy as np
import pytest

from emulator.events import EVENT_DTYPE, Events
from scenarios.converge import COLUMNS, converge, piece_times_us
from scenarios.matching import match
from sim import Crossing, CrossingConfig, Lighting

PIECE_PX = 1.5
FINE = ("full", 6, 0.25, 0.0)
FULL = ("full", 2, 0.5, 0.0)


def rows(config: CrossingConfig) -> dict[str, dict[str, Any]]:
    default = ("keyframes", config.supersample, config.step_px, config.keyframe_px)
    ways = {"fine": FINE, "full": FULL, "default": default}
    found = converge(config, PIECE_PX, ways.values())
    return {
        name: dict(zip(COLUMNS[1:], row, strict=True))
        for name, row in zip(ways, found, strict=True)
    }


@pytest.mark.parametrize("lighting", [Lighting.DAY, Lighting.NIGHT])
def test_the_default_is_no_worse_than_drawing_every_sample_in_full(lighting: Lighting) -> None:
    drawn = rows(CrossingConfig(lighting=lighting))
    full, default = drawn["full"], drawn["default"]
    assert drawn["fine"]["events"] == 0
    assert abs(default["events"]) < abs(full["events"])
    assert default["median_us"] <= full["median_us"]
    for side in ("found", "real"):
        assert default[f"{side}_within_200us"] >= full[f"{side}_within_200us"] - 0.01
        # At night the renderer's own shadows lie a few centimetres from where geometry has them.
        assert default[f"{side}_within_2000us"] >= full[f"{side}_within_2000us"] - 0.02


def test_the_piece_is_as_long_as_asked_for() -> None:
    crossing = Crossing(CrossingConfig())
    times_us = piece_times_us(crossing, 3.0, 0.5)
    speed_px_s = 1.61 * crossing.intrinsics.focal_px
    assert len(times_us) == 7
    assert (times_us[-1] - times_us[0]) * 1e-6 * speed_px_s == pytest.approx(3.0, rel=1e-3)


def stream(*rows: tuple[int, int, int, bool]) -> Events:
    return np.array(list(rows), EVENT_DTYPE)


def test_an_event_matches_the_nearest_of_its_pixel_and_polarity() -> None:
    reference = stream((100, 1, 2, True), (5000, 1, 2, True), (9000, 3, 2, False))
    events = stream((4700, 1, 2, True), (5600, 1, 2, True), (9000, 3, 2, True))
    found = match(events, reference)
    assert found.count == 0
    assert found.real == pytest.approx((0, 1 / 3, 2 / 3, 2 / 3))
    assert found.found == pytest.approx((0, 1 / 3, 1 / 3, 1 / 3))
    assert found.median_us == 450


def test_a_stream_matches_itself() -> None:
    rng = np.random.default_rng(0)
    events = np.zeros(500, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, 10_000, 500))
    events["x"], events["y"] = rng.integers(0, 346, 500), rng.integers(0, 260, 500)
    found = match(events, events)
    assert found.found == found.real == (1, 1, 1, 1)
    assert found.median_us == 0
