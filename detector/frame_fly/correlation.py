"""T4 and T5 of the frame-based fly: ensembles of opponent correlators, and what sums them.

The equations are those of Fu and Yue (2020); `detector.fly.correlation` has the event-driven fly's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.frame_fly.pathways import share_of_present
from flybench.kernels import compiled

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

_BELOW_HALF = math.nextafter(0.5, 0.0)


def delayed(now: F32, before: F32, *, interval_us: float, tau_us: float) -> F32:
    """A signal's delayed copy: a mix of its last two frames, α·x(t) + (1 − α)·x(t−1).

    Args:
        now: the signal at this frame.
        before: the signal at the frame before.
        interval_us: time between the two [µs].
        tau_us: time constant of the delay [µs].
    """
    return _mixed(now, before, share=share_of_present(interval_us, tau_us))


def opponent_motion(
    now: F32,
    before: F32,
    *,
    interval_us: float,
    offsets: Sequence[int],
    delays_us: Sequence[float],
) -> F32:
    """Full correlators along both axes, summed over their distances.

    A correlator multiplies the delayed signal of a point with the present one of a point further
    on, and subtracts the same with the delay exchanged. It is noted at the pair's midpoint, or the
    cell before it.

    Args:
        now: one pathway's signal at this frame, (rows, columns), ≥ 0.
        before: the same at the frame before.
        interval_us: time between the two [µs].
        offsets: distances between the two points [cells].
        delays_us: time constant of the delay at each distance [µs].

    Returns:
        (2, rows, columns) float32: rightward minus leftward, downward minus upward.
    """
    motion = np.zeros((2, *now.shape), np.float32)
    for offset, tau_us in zip(offsets, delays_us, strict=True):
        late = delayed(now, before, interval_us=interval_us, tau_us=tau_us)
        _add_correlators(motion, now, late, offset)
    return motion


@compiled
def _add_correlators(motion: Any, now: Any, late: Any, offset: int) -> None:
    """Add the pairs at a distance along both axes where their midpoints are."""
    rows, columns = now.shape
    first = offset // 2
    for y in range(rows):
        middle = motion[0, y, first:]
        near_now, near_late = now[y], late[y]
        far_now, far_late = now[y, offset:], late[y, offset:]
        for x in range(columns - offset):
            middle[x] += near_late[x] * far_now[x] - near_now[x] * far_late[x]
    for y in range(rows - offset):
        middle = motion[1, y + first]
        near_now, near_late = now[y], late[y]
        far_now, far_late = now[y + offset], late[y + offset]
        for x in range(columns):
            middle[x] += near_late[x] * far_now[x] - near_now[x] * far_late[x]


def smoothed(now: F32, before: F32, *, share: float) -> F32:
    """T4 and T5 in time: `share` of the present and the rest of the past."""
    return _mixed(now, before, share=share)


def _mixed(now: F32, before: F32, *, share: float) -> F32:
    mix = np.empty(now.shape, np.float32)
    _mix(now.ravel(), before.ravel(), np.float32(share), mix.ravel())
    return mix


@compiled
def _mix(now: Any, before: Any, share: Any, mix: Any) -> None:
    rest = np.float32(1.0) - share
    for k in range(now.size):
        mix[k] = share * now[k] + rest * before[k]


def tangential_response(total: float, *, cells: int, scale: float) -> float:
    """One pathway's share of HS or VS: sgn(S)·(1 / (1 + e^(−|S| / (N·C))) − 1/2).

    Args:
        total: S, the sum of a direction map.
        cells: N, the number of cells in the map.
        scale: C, the response a cell that it scales by.

    Returns:
        In (−1/2, 1/2); HS and VS are the sums of an ON and an OFF pathway.
    """
    response = 0.5 * math.tanh(total / (2.0 * cells * scale))
    return max(-_BELOW_HALF, min(_BELOW_HALF, response))


def block_sums(maps: F32, *, side: int) -> F64:
    """Sums over square blocks; those at the right and lower edge are what is left.

    Args:
        maps: (maps, rows, columns).
        side: of a block [cells].

    Returns:
        (maps, rows of blocks, columns of blocks) float64.
    """
    number, rows, columns = maps.shape
    sums = np.zeros((number, -(-rows // side), -(-columns // side)))
    _add_up(maps, side, sums)
    return sums


@compiled
def _add_up(maps: Any, side: int, sums: Any) -> None:
    number, rows, columns = maps.shape
    line = np.empty(columns)
    for n in range(number):
        for block in range(sums.shape[1]):
            line[:] = 0.0
            for y in range(block * side, min((block + 1) * side, rows)):
                row = maps[n, y]
                for x in range(columns):
                    line[x] += row[x]
            for k in range(sums.shape[2]):
                for x in range(k * side, min((k + 1) * side, columns)):
                    sums[n, block, k] += line[x]


def block_signal_to_noise(sums: F64) -> tuple[float, float]:
    """How far HS and VS stand out from what does not agree; see `detector.fly.tangential`.

    Neighbours share their input through the Gaussians and cannot be counted as independent, so
    the ratio |Σd| / √Σd² is taken over sums of blocks. With blocks of the smaller kernel's side,
    5, sensor noise alone has a ratio of 1.16 (root mean square); larger ones change that little,
    but leave so few blocks that what does move cannot reach much.

    Args:
        sums: `block_sums` of the opponent map, (2, rows, columns).

    Returns:
        The ratio of HS and of VS; 0 in suppress_output.
    """
    totals, powers = np.abs(sums.sum(axis=(1, 2))), np.sqrt((sums**2).sum(axis=(1, 2)))
    horizontal, vertical = np.divide(totals, powers, out=np.zeros(2), where=powers > 0.0)
    return float(horizontal), float(vertical)
