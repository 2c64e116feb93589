"""When to look: samples whose step follows the motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator

MIN_STEP_US = 10
"""Below this the sensor's µs stamps would get coarse (assumed)."""


def sample_times_us(
    start_us: int,
    end_us: int,
    speed_px_s: Callable[[int], float],
    *,
    step_px: float,
    max_step_us: int,
) -> Iterator[int]:
    """Times from `start_us` to `end_us`, both included, so close that nothing moves too far.

    Args:
        start_us: first sample [µs].
        end_us: last sample [µs].
        speed_px_s: the fastest image motion at a time [px/s]; 0 where nothing moves. It may begin
            and end at any time, but not do both within `max_step_us`.
        step_px: the farthest that a point may travel between two samples [px].
        max_step_us: the longest step [µs].

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
