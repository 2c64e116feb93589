"""T4 and T5 of the frame-based fly: ensembles of opponent correlators, and what sums them.

The equations are those of Fu and Yue (2020); `detector.correlation` has the event-driven fly's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from detector.frame_pathways import share_of_present

F32 = npt.NDArray[np.float32]

_BELOW_HALF = math.nextafter(0.5, 0.0)


def delayed(now: F32, before: F32, *, interval_us: float, tau_us: float) -> F32:
    """A signal's delayed copy: a mix of its last two frames, α·x(t) + (1 − α)·x(t−1).

    Args:
        now: the signal at this frame.
        before: the signal at the frame before.
        interval_us: time between the two [µs].
        tau_us: time constant of the delay [µs].
    """
    alpha = np.float32(share_of_present(interval_us, tau_us))
    return np.asarray(alpha * now + (1 - alpha) * before, np.float32)


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
        for axis in (0, 1):
            _add_correlators(motion[axis], now, late, offset, axis=1 - axis)
    return motion


def _add_correlators(motion: F32, now: F32, late: F32, offset: int, *, axis: int) -> None:
    """Add the pairs at a distance along an array's axis where their midpoints are."""
    length = now.shape[axis]
    if offset >= length:
        return
    near = tuple(slice(None, length - offset) if a == axis else slice(None) for a in (0, 1))
    far = tuple(slice(offset, None) if a == axis else slice(None) for a in (0, 1))
    first = offset // 2
    middle = tuple(
        slice(first, first + length - offset) if a == axis else slice(None) for a in (0, 1)
    )
    motion[middle] += late[near] * now[far] - now[near] * late[far]


def smoothed(now: F32, before: F32, *, share: float) -> F32:
    """T4 and T5 in time: `share` of the present and the rest of the past."""
    weight = np.float32(share)
    return np.asarray(weight * now + (1 - weight) * before, np.float32)


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


def block_signal_to_noise(motion: F32, *, side: int) -> tuple[float, float]:
    """How far HS and VS stand out from what does not agree; see `detector.tangential`.

    Neighbours share their input through the Gaussians and cannot be counted as independent, so
    the ratio |Σd| / √Σd² is taken over sums of blocks. With blocks of the smaller kernel's side,
    5, sensor noise alone has a ratio of 1.16 (root mean square); larger ones change that little,
    but leave so few blocks that what does move cannot reach much.

    Args:
        motion: opponent map, (2, rows, columns).
        side: of a block [cells].

    Returns:
        The ratio of HS and of VS; 0 in silence.
    """
    _, rows, columns = motion.shape
    sums = np.add.reduceat(motion.astype(np.float64), np.arange(0, rows, side), axis=1)
    sums = np.add.reduceat(sums, np.arange(0, columns, side), axis=2).reshape(2, -1)
    totals, powers = np.abs(sums.sum(axis=1)), np.sqrt((sums**2).sum(axis=1))
    horizontal, vertical = np.divide(totals, powers, out=np.zeros(2), where=powers > 0.0)
    return float(horizontal), float(vertical)
