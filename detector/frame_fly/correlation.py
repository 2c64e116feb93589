"""T4, T5 and the tangential cells of the frame-based fly: opponent correlators and their sums.

The equations are those of Fu and Yue (2020). Those of the event-driven fly are in
`detector.fly.correlation`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.frame_fly.pathways import weight_of_present
from flybench.kernels import compiled

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

_BELOW_HALF = math.nextafter(0.5, 0.0)


def delayed(now: F32, before: F32, *, interval_us: float, tau_us: float) -> F32:
    """Return the delayed signal, a mix of its last two frames: α·x(t) + (1 − α)·x(t−1).

    Args:
        now: signal at this frame.
        before: signal at the previous frame.
        interval_us: time between the two frames [µs].
        tau_us: time constant of the delay [µs].
    """
    return _mixed(now, before, weight=weight_of_present(interval_us, tau_us))


def opponent_motion(
    now: F32,
    before: F32,
    *,
    interval_us: float,
    offsets: Sequence[int],
    delays_us: Sequence[float],
) -> F32:
    """Correlate one pathway along both axes and sum over the distances.

    A correlator multiplies the delayed signal of a point with the present signal of a point further
    along the axis, and subtracts the product with the delay exchanged. Its output belongs to the
    midpoint of the pair, or to the cell before it if the midpoint lies between two cells.

    Args:
        now: signal of the pathway at this frame, (rows, columns), ≥ 0.
        before: signal of the pathway at the previous frame, (rows, columns), ≥ 0.
        interval_us: time between the two frames [µs].
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
    """Add the correlators of all pairs at one distance, each at the midpoint of its pair."""
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


def smoothed(now: F32, before: F32, *, weight: float) -> F32:
    """Smooth T4 and T5 in time: `weight` of the present and the rest of the past."""
    return _mixed(now, before, weight=weight)


def _mixed(now: F32, before: F32, *, weight: float) -> F32:
    mix = np.empty(now.shape, np.float32)
    _mix(now.ravel(), before.ravel(), np.float32(weight), mix.ravel())
    return mix


@compiled
def _mix(now: Any, before: Any, weight: Any, mix: Any) -> None:
    rest = np.float32(1.0) - weight
    for k in range(now.size):
        mix[k] = weight * now[k] + rest * before[k]


def tangential_response(total: float, *, cells: int, scale: float) -> float:
    """Return the part of HS or VS from one pathway: sgn(S)·(1 / (1 + e^(−|S| / (N·C))) − 1/2).

    Args:
        total: S, the sum of a direction map.
        cells: N, the number of cells in the map.
        scale: C, the response per cell that scales the sigmoid.

    Returns:
        Value in (−1/2, 1/2); HS and VS are each the sum of the ON and the OFF pathway.
    """
    response = 0.5 * math.tanh(total / (2.0 * cells * scale))
    return max(-_BELOW_HALF, min(_BELOW_HALF, response))


def block_sums(maps: F32, *, side: int) -> F64:
    """Sum maps over square blocks; blocks at the right and lower edge may be smaller.

    Args:
        maps: (maps, rows, columns).
        side: side of a block [cells].

    Returns:
        (maps, rows of blocks, columns of blocks) float64.
    """
    number, rows, columns = maps.shape
    sums = np.zeros((number, -(-rows // side), -(-columns // side)))
    _add_blocks(maps, side, sums)
    return sums


@compiled
def _add_blocks(maps: Any, side: int, sums: Any) -> None:
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
    """Return the ratios of HS and VS to what blocks of random sign would give.

    The ratio is |Σd| / √Σd², as in `detector.fly.tangential.signal_to_noise`, but d is the sum of a
    block: neighbouring cells share their input through the Gaussians and are not independent. With
    blocks of 5 cells a side, the side of the smaller kernel, sensor noise alone has a ratio of 1.16
    (root mean square). Larger blocks change that little, but leave so few blocks that motion cannot
    reach a high ratio.

    Args:
        sums: `block_sums` of the opponent map, (2, rows, columns).

    Returns:
        The ratios of HS and VS; 0 if no block responds.
    """
    totals, powers = np.abs(sums.sum(axis=(1, 2))), np.sqrt((sums**2).sum(axis=(1, 2)))
    horizontal, vertical = np.divide(totals, powers, out=np.zeros(2), where=powers > 0.0)
    return float(horizontal), float(vertical)
