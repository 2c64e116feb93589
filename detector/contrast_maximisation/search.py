"""The search for the velocity of highest reward, from coarse to fine, with or without a start.

The width of a reward's peak follows from the image: a candidate that is wrong by Δv smears the
events of a window T over Δv·T. A grid with steps of s/T and an image with pixels of side s
therefore miss no peak, and halving s halves the steps.

A cold search scans all velocities up to a limit. A warm search starts from a given velocity.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]
RewardAt = Callable[[F64, float], F64]
"""(n, 2) velocities [px/s] and the image's pixel side [px] → (n,) rewards."""
Velocity = tuple[float, float]

_COARSEST_PX = 4.0
"""Pixel side in the scan of a cold search [px]: less than the distance between the edges of a
vehicle (assumed)."""
_FINEST_SMEAR_PX = 1 / 4
"""Step of the last grid, as the distance over which it smears events [px]; within it a reward is a
parabola. Steps of 1/16 px changed no error on synthetic dots of 120 to 1000 px/s by more than
0.03 px/s."""
_FIT_SMEAR_PX = 1 / 4
"""Step between the samples of the parabola fit, as the distance over which it smears events [px]
(assumed)."""
_KEPT = (8, 3, 3)
"""Number of candidates that are followed to images with pixels of 4, 2 and 1 px (assumed)."""
_WARM_PX = 2.0
"""Pixel side in a warm search near its start [px]. Its grid has two steps to all sides (assumed):
80 px/s with windows of 50 ms, which is an acceleration of 1600 px/s² over one window."""
_WARM_SCAN_PX = 8.0
"""Pixel side in the scan of a warm search [px]. It is coarse and only leads to the foot of a peak;
from there the search climbs with all events (assumed)."""
_EQUAL_SHARE = 0.75
"""Least reward of a peak, relative to the highest, at which the two count as equally high. Two
equally sharp images of a drawn, tilted bar differ by up to 25 %, because the edge falls on pixels
in different ways."""
_MOST_CLIMBS = 20
"""Largest number of moves of a grid before the next finer grid (assumed). A peak is 1 to 3 moves
away."""


class _CachedRewards:
    """Rewards that are computed once: a grid shares points with the grids before it."""

    def __init__(self, reward_at: RewardAt) -> None:
        self._reward_at = reward_at
        self._known: dict[tuple[float, float, float], float] = {}

    def __call__(self, velocities: F64, scale_px: float) -> F64:
        keys = [(x, y, scale_px) for x, y in velocities.round(6).tolist()]
        new = [n for n, key in enumerate(keys) if key not in self._known]
        if new:
            found = self._reward_at(velocities[new], scale_px)
            self._known.update(zip((keys[n] for n in new), found.tolist(), strict=True))
        return np.array([self._known[key] for key in keys])


def search_cold(
    reward_at: RewardAt,
    *,
    window_s: float,
    limit_px_s: float,
    cold_scan_at: RewardAt | None = None,
) -> Velocity:
    """Return the velocity of highest reward among all velocities up to a limit.

    Args:
        reward_at: rewards of candidates.
        window_s: T, span of the events [s].
        limit_px_s: highest speed that is searched [px/s].
        cold_scan_at: rewards from fewer events, for the first scan; None: `reward_at`.
    """
    step, reward_at = _COARSEST_PX / window_s, _CachedRewards(reward_at)
    grid = disc(limit_px_s, step)
    best = _peaks(
        grid, (cold_scan_at or reward_at)(grid, _COARSEST_PX), apart=1.5 * step, number=_KEPT[0]
    )
    scale = _COARSEST_PX
    for kept in _KEPT[1:]:
        scale, step = scale / 2, step / 2
        climbed = [_climb(reward_at, v, step, scale) for v in best]
        ends = np.array([v for v, _ in climbed])
        best = _peaks(ends, np.array([r for _, r in climbed]), apart=step, number=kept)
    return _slowest(reward_at, [_refine(reward_at, v, step, window_s) for v in best])


def search_warm(
    reward_at: RewardAt,
    warm_scan_at: RewardAt,
    start: Velocity,
    *,
    window_s: float,
    limit_px_s: float,
) -> Velocity:
    """Return the velocity of highest reward near a start or near the best of a cheap scan.

    A search near the start alone would stay on a lower peak for as long as that peak exists.

    Args:
        reward_at: rewards of candidates.
        warm_scan_at: rewards from few events, cheap enough to scan all velocities.
        start: velocity to start from, such as that of the previous window [px/s].
        window_s: T, span of the events [s].
        limit_px_s: highest speed that is searched [px/s].
    """
    step, reward_at = _WARM_PX / window_s, _CachedRewards(reward_at)
    near = start + square(2, step)
    found = reward_at(near, _WARM_PX)
    best = [_climb(reward_at, _pair(near[int(found.argmax())]), step / 2, 1.0)]
    grid = disc(limit_px_s, _WARM_SCAN_PX / window_s)
    there = _pair(grid[int(warm_scan_at(grid, _WARM_SCAN_PX).argmax())])
    if math.dist(there, best[0][0]) > _WARM_SCAN_PX / window_s:
        there, _ = _climb(reward_at, there, 2 * step, _COARSEST_PX)
        there, _ = _climb(reward_at, there, step, _WARM_PX)
        best.append(_climb(reward_at, there, step / 2, 1.0))
    return _slowest(reward_at, [_refine(reward_at, v, step / 2, window_s) for v, _ in best])


def _slowest(reward_at: RewardAt, peaks: Sequence[Velocity]) -> Velocity:
    """Return the slowest of the peaks that are about as high as the highest.

    A straight edge is as sharp at every velocity with the same component normal to it; the slowest
    of these is that component.
    """
    rewards = reward_at(np.array(peaks), 1.0)
    highest = rewards.max()
    share = _EQUAL_SHARE if highest > 0 else 2 - _EQUAL_SHARE  # edges make rewards negative
    is_equal = rewards >= share * highest
    equal = [peak for peak, kept in zip(peaks, is_equal, strict=True) if kept]
    return min(equal, key=lambda velocity: math.hypot(*velocity))


def _pair(velocity: F64) -> Velocity:
    return float(velocity[0]), float(velocity[1])


def disc(radius: float, step: float) -> F64:
    """Return the points of a square grid through (0, 0) within `radius` of it, (n, 2)."""
    reach = math.ceil(radius / step)
    grid = square(reach, step)
    return np.asarray(grid[np.hypot(*grid.T) <= radius], np.float64)


def square(reach: int, step: float) -> F64:
    """Return the points of a square grid around (0, 0), `reach` steps to all sides, (n, 2)."""
    return np.asarray(_unit_square(reach) * step, np.float64)


@lru_cache(maxsize=8)
def _unit_square(reach: int) -> npt.NDArray[np.int64]:
    """Return the points of `square` in steps, (n, 2); cached, so callers must not change it."""
    axis = np.arange(-reach, reach + 1)
    return np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)


def _peaks(points: F64, found: F64, *, apart: float, number: int) -> list[Velocity]:
    """Return the highest points, each more than `apart` along an axis from every higher one."""
    chosen: list[Velocity] = []
    for n in np.argsort(-found, kind="stable"):
        x, y = float(points[n, 0]), float(points[n, 1])
        if all(max(abs(x - a), abs(y - b)) > apart for a, b in chosen):
            chosen.append((x, y))
            if len(chosen) == number:
                break
    return chosen


def _climb(
    reward_at: RewardAt, start: Velocity, step: float, scale_px: float
) -> tuple[Velocity, float]:
    """Move a grid of 3×3 candidates until its centre is the best; return it and its reward."""
    around = square(1, step)
    here, best = start, -math.inf
    for _ in range(_MOST_CLIMBS):
        grid = here + around
        found = reward_at(grid, scale_px)
        n = int(found.argmax())
        best = float(found[n])
        if n == len(grid) // 2 or best <= found[len(grid) // 2]:
            break
        here = (float(grid[n, 0]), float(grid[n, 1]))
    return here, best


def _refine(reward_at: RewardAt, start: Velocity, step: float, window_s: float) -> Velocity:
    """Halve the steps with image pixels of 1 px, then return the peak of a fitted paraboloid."""
    here = start
    while step > _FINEST_SMEAR_PX / window_s:
        step /= 2
        here, _ = _climb(reward_at, here, step, 1.0)
    offsets = square(2, _FIT_SMEAR_PX / window_s)
    shift = parabola_peak(offsets, reward_at(here + offsets, 1.0))
    return here[0] + shift[0], here[1] + shift[1]


def parabola_peak(offsets: F64, values: F64) -> Velocity:
    """Return the peak of the least-squares paraboloid through samples; (0, 0) if it has none.

    Args:
        offsets: (n, 2) positions of the samples, relative to the best candidate.
        values: (n,) samples.

    Returns:
        (x, y), never farther out than the samples; (0, 0) instead.
    """
    unit = float(np.abs(offsets).max())
    x, y = (offsets / unit).T
    terms: Sequence[F64] = (np.ones_like(x), x, y, x * x, x * y, y * y)
    spread = float(np.ptp(values)) or 1.0
    _, a, b, c, d, e = np.linalg.lstsq(
        np.stack(terms, axis=1), (values - values.mean()) / spread, rcond=None
    )[0]
    determinant = 4 * c * e - d * d
    if c >= 0 or determinant <= 0:
        return 0.0, 0.0
    peak = (d * b - 2 * e * a) / determinant, (d * a - 2 * c * b) / determinant
    if max(abs(peak[0]), abs(peak[1])) > 1.0:
        return 0.0, 0.0
    return float(peak[0]) * unit, float(peak[1]) * unit
