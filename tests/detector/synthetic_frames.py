"""Synthetic frames of gratings and bars that move at constant speed, with sensor noise."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from detector.estimate import MotionEstimate
from detector.frame_fly.detector import FrameFly
from flybench.direction import Direction

WIDTH, HEIGHT = 173, 130
BASE_DN = 300.0
NOISE_DN = 2.0

U16 = npt.NDArray[np.uint16]
F64 = npt.NDArray[np.float64]
Profile = Callable[[F64], F64]
"""Brightness [DN] at positions on the pattern along the direction of motion [px]."""


def grating(period_px: float, *, contrast: float = 0.4) -> Profile:
    """Return the profile of a sine grating."""
    return lambda x: BASE_DN * (1 + contrast * np.sin(2 * np.pi * x / period_px))


def bar(width_px: float, *, level_dn: float = 500.0) -> Profile:
    """Return the profile of a bar centred at 0; pixels at its edges are partly covered."""

    def profile(x: F64) -> F64:
        cover = np.clip(width_px / 2 + 0.5 - np.abs(x), 0.0, 1.0)
        return BASE_DN + (level_dn - BASE_DN) * cover

    return profile


def frames(
    profile: Profile,
    *,
    step_px: float,
    number: int,
    direction: Direction = Direction.RIGHT,
    start_px: float = 30.0,
    seed: int = 0,
) -> Iterator[U16]:
    """Generate frames of a pattern that moves by `step_px` per frame."""
    rng = np.random.default_rng(seed)
    shape = (HEIGHT, WIDTH)
    if direction in (Direction.UP, Direction.DOWN):
        shape = (WIDTH, HEIGHT)
    for n in range(number):
        line = profile(np.arange(WIDTH, dtype=np.float64) - (start_px + n * step_px))
        image = np.tile(line, (HEIGHT, 1))
        if direction in (Direction.LEFT, Direction.UP):
            image = image[:, ::-1]
        if direction in (Direction.UP, Direction.DOWN):
            image = image.T
        noisy = image + NOISE_DN * rng.standard_normal(shape)
        yield np.clip(noisy, 0, 1023).astype(np.uint16)


def run_on_frames(
    fly: FrameFly, images: Iterator[U16], *, interval_us: int
) -> list[MotionEstimate]:
    """Return the estimates for frames at a constant rate."""
    estimates: list[MotionEstimate] = []
    for n, image in enumerate(images):
        estimates += fly.push_frame(n * interval_us, image)
    return estimates
