"""Thresholds against a plain-Python account of the same pixel."""

import numpy as np
import pytest

from flybench.events import Events
from scenarios.envelope import pixels
from scenarios.envelope.pixels import THETA_OFF, THETA_ON, Canvas

WHOLE = (0, 0, 8, 6)
STILL = np.zeros(2)


@pytest.fixture(autouse=True)
def _no_mismatch(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pixels, "THETA_MISMATCH", 0.0)


def canvas_of(paint: float, *, cover: float = 1.0, ground: float = 0.0) -> Canvas:
    block = np.full((2, 3), paint, np.float32)
    made = Canvas(
        np.full((10, 12), ground, np.float32),
        [block],
        [np.full((2, 3), cover, np.float32)],
        margin_px=2,
        rng=np.random.default_rng(0),
    )
    made.settle(STILL, np.array([[-10.0, 1.0]]))
    return made


def show(canvas: Canvas, x: float, y: float = 1.0, *, start_us: float = 0.0) -> Events:
    return canvas.look(STILL, np.array([[x, y]]), WHOLE, start_us=start_us, step_us=1000.0)


def test_what_appears_fires_every_time_a_threshold_is_crossed() -> None:
    events = show(canvas_of(1.0), 2.0)
    crossings = np.arange(THETA_ON, 1.0, THETA_ON)
    assert set(zip(events["x"].tolist(), events["y"].tolist(), strict=True)) == {
        (x, y) for x in (2, 3, 4) for y in (1, 2)
    }
    assert events["p"].all()
    one = events[(events["x"] == 3) & (events["y"] == 2)]
    np.testing.assert_allclose(one["t"], crossings * 1000, atol=1)


def test_what_darkens_fires_off() -> None:
    events = show(canvas_of(-0.5), 2.0)
    assert not events["p"].any()
    assert events.size == 6 * int(0.5 / THETA_OFF)


def test_what_stays_does_not_fire_and_a_rest_is_kept() -> None:
    canvas = canvas_of(0.1)  # less than a threshold
    assert show(canvas, 2.0).size == 0
    assert show(canvas, 2.0).size == 0
    other = canvas_of(2.2 * THETA_ON)
    assert show(other, 2.0).size == 2 * 6
    gone = show(other, -10.0, start_us=1000.0)  # back by 2 ON thresholds: 1.6 OFF ones
    assert gone.size == 6
    assert not gone["p"].any()
    assert (gone["t"] > 1000).all()


def test_a_pixel_takes_the_share_of_its_area() -> None:
    canvas = canvas_of(1.0)
    show(canvas, 2.25)
    row = canvas._seen[1]
    np.testing.assert_allclose(row[:7], [0, 0, 0.75, 1, 1, 0.25, 0], atol=1e-6)


def test_what_is_see_through_shows_what_is_behind() -> None:
    canvas = canvas_of(1.0, cover=0.0, ground=0.5)
    assert show(canvas, 2.0).size == 0
    np.testing.assert_allclose(canvas._seen, 0.5)


def test_a_region_is_all_that_is_looked_at() -> None:
    events = canvas_of(1.0).look(
        STILL, np.array([[2.0, 1.0]]), (3, 1, 4, 2), start_us=0.0, step_us=1000.0
    )
    assert set(events["x"]) == {3}
    assert set(events["y"]) == {1}


def test_a_moving_background_moves_in_every_pixel() -> None:
    ground = np.tile(np.arange(12, dtype=np.float32), (10, 1))
    canvas = Canvas(ground, [np.zeros((1, 1), np.float32)], [np.zeros((1, 1), np.float32)],
                    margin_px=2, rng=np.random.default_rng(0))  # fmt: skip
    canvas.settle(STILL, np.array([[0.0, 0.0]]))
    np.testing.assert_allclose(canvas._seen[0], np.arange(2, 10))
    canvas.look(np.array([-1.5, 0.0]), np.array([[0.0, 0.0]]), WHOLE, start_us=0, step_us=1000.0)
    np.testing.assert_allclose(canvas._seen[3], np.arange(2, 10) + 1.5)
