"""Times of the samples: the step follows the motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator

MIN_STEP_US = 10
"""Shortest step [µs] (assumed): for shorter steps the 1 µs resolution of the sensor's time stamps
would be too coarse."""


def sample_times_us(
    start_us: int,
    end_us: int,
    speed_px_s: Callable[[int], float],
    *,
    step_px: float,
    max_step_us: int,
) -> Iterator[int]:
    """Yield sample times from `start_us` to `end_us`, both included.

    Between two samples no point moves farther than `step_px`.

    Args:
        start_us: time of the first sample [µs].
        end_us: time of the last sample [µs].
        speed_px_s: returns the fastest image motion at a time [µs], 0 if nothing moves [px/s].
            Motion may begin and end at any time, but not both within `max_step_us`.
        step_px: largest distance that a point may move between two samples [px].
        max_step_us: longest step [µs].

    Yields:
        Times [µs], strictly increasing.
    """
    t_us = start_us
    while t_us < end_us:
        yield t_us
        speed = max(speed_px_s(t_us), speed_px_s(min(t_us + max_step_us, end_us)))
        step = max_step_us if speed <= 0 else int(min(max_step_us, 1e6 * step_px / speed))
        t_us += max(step, MIN_STEP_US)
    yield end_us
