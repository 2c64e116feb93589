"""The search for the velocity of highest reward: coarse to fine, cold or warm.

How sharp a reward's peak is follows from the image: a candidate that is wrong by Δv smears the
events of a window T over Δv·T. So a grid of steps s/T with an image of pixels s misses no peak,
and halving s halves the steps.
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
Candidate = tuple[float, float]

_COARSEST_PX = 4.0
"""Pixel side of the cold search's grid: narrower than what edges of a vehicle are apart
(assumed)."""
_FINEST_SMEAR_PX = 1 / 4
"""Step of the last grid, as the distance it smears over: under it a reward is a parabola. Steps of
1/16 changed no error on drawn dots of 120 to 1000 px/s by more than 0.03 px/s."""
_FIT_SMEAR_PX = 1 / 4
"""Half the step of the fit's samples on either side of the peak, likewise (assumed)."""
_KEPT = (8, 3, 1)
"""Candidates that are followed to images of 4, 2 and 1 px (assumed)."""
_WARM_PX = 2.0
"""Pixel side of the warm search's grid, which spans two of its steps to all sides (assumed): 80
px/s with windows of 50 ms, the change of speed of 1600 px/s² over one window."""
_GLANCE_PX = 8.0
"""Pixel side of the warm search's glance, as coarse as leads to a hill's foot (assumed): from there
it climbs with all events."""
_MOST_CLIMBS = 20
"""Moves of a grid's centre before the next finer grid (assumed); a peak is 1 to 3 away."""


class _Known:
    """Rewards, each asked for once: grids share points with those before them."""

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
    survey_at: RewardAt | None = None,
) -> Candidate:
    """Highest reward among all velocities up to a limit.

    Args:
        reward_at: the reward of candidates.
        window_s: T, span of the events [s].
        limit_px_s: highest speed looked for [px/s].
        survey_at: the same by a part of the events, for the first look all over; None: by all.
    """
    step, reward_at = _COARSEST_PX / window_s, _Known(reward_at)
    grid = disc(limit_px_s, step)
    best = _peaks(
        grid, (survey_at or reward_at)(grid, _COARSEST_PX), apart=1.5 * step, number=_KEPT[0]
    )
    scale = _COARSEST_PX
    for kept in _KEPT[1:]:
        scale, step = scale / 2, step / 2
        climbed = [_climb(reward_at, v, step, scale) for v in best]
        ends = np.array([v for v, _ in climbed])
        best = _peaks(ends, np.array([r for _, r in climbed]), apart=step, number=kept)
    return _refine(reward_at, best[0], step, window_s)


def search_warm(
    reward_at: RewardAt,
    glance_at: RewardAt,
    start: Candidate,
    *,
    window_s: float,
    limit_px_s: float,
) -> Candidate:
    """Highest reward near a velocity, such as the window before's, or where a glance leads.

    Looking near the start alone would keep to a lower peak for as long as it is one.

    Args:
        reward_at: the reward of candidates.
        glance_at: the same by a part of the events, cheap enough to look all over.
        start: velocity to start from [px/s].
        window_s: T, span of the events [s].
        limit_px_s: highest speed looked for [px/s].
    """
    step, reward_at = _WARM_PX / window_s, _Known(reward_at)
    near = start + square(2, step)
    found = reward_at(near, _WARM_PX)
    best = [_climb(reward_at, _pair(near[int(found.argmax())]), step / 2, 1.0)]
    grid = disc(limit_px_s, _GLANCE_PX / window_s)
    there = _pair(grid[int(glance_at(grid, _GLANCE_PX).argmax())])
    if math.dist(there, best[0][0]) > _GLANCE_PX / window_s:
        there, _ = _climb(reward_at, there, 2 * step, _COARSEST_PX)
        there, _ = _climb(reward_at, there, step, _WARM_PX)
        best.append(_climb(reward_at, there, step / 2, 1.0))
    highest, _ = max(best, key=lambda climbed: climbed[1])
    return _refine(reward_at, highest, step / 2, window_s)


def _pair(velocity: F64) -> Candidate:
    return float(velocity[0]), float(velocity[1])


def disc(radius: float, step: float) -> F64:
    """Points of a square grid with (0, 0) no farther from it than `radius`, (n, 2)."""
    reach = math.ceil(radius / step)
    grid = square(reach, step)
    return np.asarray(grid[np.hypot(*grid.T) <= radius], np.float64)


def square(reach: int, step: float) -> F64:
    """Points of a square grid around (0, 0), `reach` steps to all sides, (n, 2)."""
    return np.asarray(_unit_square(reach) * step, np.float64)


@lru_cache(maxsize=8)
def _unit_square(reach: int) -> npt.NDArray[np.int64]:
    """The same in steps; not to be changed."""
    axis = np.arange(-reach, reach + 1)
    return np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)


def _peaks(points: F64, found: F64, *, apart: float, number: int) -> list[Candidate]:
    """The highest points of all, none nearer to a higher one than `apart` along both axes."""
    chosen: list[Candidate] = []
    for n in np.argsort(-found, kind="stable"):
        x, y = float(points[n, 0]), float(points[n, 1])
        if all(max(abs(x - a), abs(y - b)) > apart for a, b in chosen):
            chosen.append((x, y))
            if len(chosen) == number:
                break
    return chosen


def _climb(
    reward_at: RewardAt, start: Candidate, step: float, scale_px: float
) -> tuple[Candidate, float]:
    """Move a grid of 3×3 candidates until its centre is the best."""
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


def _refine(reward_at: RewardAt, start: Candidate, step: float, window_s: float) -> Candidate:
    """Halve the steps at pixels of 1 px, then take the peak of a fitted parabola."""
    here = start
    while step > _FINEST_SMEAR_PX / window_s:
        step /= 2
        here, _ = _climb(reward_at, here, step, 1.0)
    offsets = square(2, _FIT_SMEAR_PX / window_s)
    shift = parabola_peak(offsets, reward_at(here + offsets, 1.0))
    return here[0] + shift[0], here[1] + shift[1]


def parabola_peak(offsets: F64, values: F64) -> Candidate:
    """Peak of the paraboloid through samples, by least squares; (0, 0) where there is none.

    Args:
        offsets: (n, 2) where the samples lie around the best.
        values: (n,) samples.

    Returns:
        (x, y), never farther out than the samples.
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
