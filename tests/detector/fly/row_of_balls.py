"""A ball that catches up with a row of balls, as in a Newton's cradle."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from flybench.events import Events
from tests.detector.stimuli import merged, size_before_turning, slide, turned

BALL_PX_S, ROW_PX_S = 1200.0, 200.0
_SIDE_PX, _BALLS, _GAP_PX = 44, 4, 60
"""Diameter of a ball, balls of the row, and distance of the row from the image's edge at first."""


def ball_behind_a_row(direction: Direction, *, enters_us: int, seed: int = 0) -> tuple[Events, int]:
    """Return events until the ball touches the row, and their duration [µs].

    The row moves slowly in the direction. The ball enters behind it, six times as fast.
    """
    width, height = size_before_turning(direction)
    duration_us = int((_GAP_PX + BALL_PX_S * enters_us * 1e-6) / (BALL_PX_S - ROW_PX_S) * 1e6)
    balls = [_ball(10 * seed + n) for n in range(_BALLS + 1)]
    rightward = [
        slide(
            pattern,
            speed_px_s=speed_px_s,
            start_px=start_px,
            top_px=(height - _SIDE_PX) // 2,
            duration_us=duration_us,
            background=np.zeros((height, width)),
            threshold=0.3,
            seed=seed,
        )
        for pattern, speed_px_s, start_px in (
            (balls[0], BALL_PX_S, -_SIDE_PX - BALL_PX_S * enters_us * 1e-6),
            (np.hstack(balls[1:]), ROW_PX_S, _GAP_PX),
        )
    ]
    return turned(merged(*rightward), direction, width=width, height=height), duration_us


def _ball(seed: int) -> npt.NDArray[np.float64]:
    """Return the log luminance of a textured ball, NaN outside of it."""
    noise = np.random.default_rng(seed).standard_normal((_SIDE_PX, _SIDE_PX))
    texture = np.asarray(cv2.GaussianBlur(noise, (0, 0), 2.0), np.float64)
    y, x = np.mgrid[:_SIDE_PX, :_SIDE_PX] - (_SIDE_PX - 1) / 2
    is_inside = np.hypot(x, y) < _SIDE_PX / 2
    return np.where(is_inside, 0.45 * texture / texture.std() - 0.5, np.nan)
