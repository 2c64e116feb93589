"""The image of warped events and its sums: the kernels of contrast maximisation.

An event at (x, y, t) is moved back along a candidate velocity v to the middle of the window,
x′ = x − v·t, and voted into an image that is then smoothed. The image is as large as the warped
events need, so that none is lost and no candidate gains from pushing events out.

One candidate costs a pass over the events and one over the image, which smooths a row, sums it up
and empties what the next candidate must not find.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flybench.kernels import compiled, compiled_fastmath, inlined, inlined_fastmath

VARIANCE, GRADIENT, SUPPRESSED, COMBINED = range(4)
"""Kinds of reward; see `detector.contrast_maximisation.warped_events.Reward`."""

SUPPRESSION = 3.0
"""p of the suppressed accumulations; the value of Stoffregen's published code."""

RIM = 4
"""Empty pixels kept around the warped events: a vote spreads by one, and by one more where it is
rounded up; smoothing spreads by one, and leaves out the outermost."""

_BLOCK = 256
"""Events whose shares are worked out at once: few enough for the fastest memory (assumed)."""


@compiled
def rewards_of(
    points: Any, boxes: Any, velocities: Any, scale: Any, kind: int, room: Any, found: Any
) -> None:
    """Reward of each velocity; `scale` is of pixels to a px, and of pixels in the fixed area."""
    for n in range(velocities.shape[0]):
        vx, vy = velocities[n]
        votes = _votes(points, points[2], boxes, vx, vy, scale[0], room)
        found[n] = _reward(votes, kind, scale[1], points.shape[1])


@compiled
def rewards_by_order(
    points: Any, box: Any, velocity: Any, orders: Any, scale: Any, kind: int, room: Any, found: Any
) -> None:
    """Reward of one velocity for each order in which the events may have exchanged their times."""
    times = np.empty_like(points[2])
    for n in range(orders.shape[0]):
        for i in range(times.size):
            times[i] = points[2, orders[n, i]]
        votes = _votes(points, times, box, velocity[0], velocity[1], scale[0], room)
        found[n] = _reward(votes, kind, scale[1], points.shape[1])


@compiled
def smoothed_image(points: Any, boxes: Any, velocity: Any, per_px: float, room: Any) -> Any:
    """The smoothed image itself."""
    votes = _votes(points, points[2], boxes, velocity[0], velocity[1], per_px, room)
    rows, columns = votes.shape
    image, line = np.zeros_like(votes), np.empty(columns, np.float32)
    for r in range(1, rows - 1):
        _smooth(votes[r - 1], votes[r], votes[r + 1], line, image[r])
    votes[:] = np.float32(0.0)
    return image


@compiled
def _votes(
    points: Any, times: Any, boxes: Any, vx: float, vy: float, per_px: float, room: Any
) -> Any:
    """Image of warped events, not smoothed yet, in the room, which is empty."""
    x0, columns = _extent(boxes, 0, vx * per_px, per_px)
    y0, rows = _extent(boxes, 1, vy * per_px, per_px)
    flat = room[: rows * columns]
    warp = np.array([per_px, vx * per_px, vy * per_px, x0, y0]).astype(np.float32)
    _vote(points[0], points[1], times, warp, flat, columns)
    return flat.reshape(rows, columns)


@compiled
def _extent(boxes: Any, axis: int, u: float, per_px: float) -> Any:
    """Origin and length of the image along an axis: what the events need, or a little more.

    The origin is whole, so that it does not matter where it is.
    """
    low, high = np.inf, -np.inf
    for n in range(boxes.shape[2]):
        early, late = u * boxes[0, 2, n], u * boxes[1, 2, n]
        low = min(low, boxes[0, axis, n] * per_px - max(early, late))
        high = max(high, boxes[1, axis, n] * per_px - min(early, late))
    origin = np.floor(low) - RIM
    return origin, int(high - origin) + RIM + 1


@compiled_fastmath
def _vote(x: Any, y: Any, t: Any, warp: Any, flat: Any, columns: int) -> None:
    """Share each event among the nine pixels around it, by a quadratic B-spline along each axis.

    A vote has the variance 1/4 wherever it falls. Bilinear ones have between 0 and 1/4, so that
    contrast would favour velocities that leave events in the middle of pixels: a component of 0
    above all, in place of slow ones.

    Shares are worked out for a block of events, many at a time, and then added one by one.
    """
    shares, places = np.empty((6, _BLOCK), np.float32), np.empty(_BLOCK, np.int32)
    for first in range(0, x.size, _BLOCK):
        end = min(first + _BLOCK, x.size)
        _share(x[first:end], y[first:end], t[first:end], warp, columns, shares, places)
        for i in range(end - first):
            left, middle, right = shares[0, i], shares[1, i], shares[2, i]
            at = places[i]
            for share in (shares[3, i], shares[4, i], shares[5, i]):
                flat[at] += left * share
                flat[at + 1] += middle * share
                flat[at + 2] += right * share
                at += columns


@inlined_fastmath
def _share(x: Any, y: Any, t: Any, warp: Any, columns: int, shares: Any, places: Any) -> None:
    """Shares of three columns and three rows, (6, events), and where the first of the nine lies."""
    per_px, ux, uy, x0, y0 = warp[0], warp[1], warp[2], warp[3], warp[4]
    half, most, width = np.float32(0.5), np.float32(0.75), np.int32(columns)
    for i in range(x.size):
        px, py = x[i] * per_px - ux * t[i] - x0, y[i] * per_px - uy * t[i] - y0
        column, row = np.int32(px + half), np.int32(py + half)
        fx, fy = px - np.float32(column), py - np.float32(row)
        shares[0, i] = half * (half - fx) * (half - fx)
        shares[1, i] = most - fx * fx
        shares[2, i] = half * (half + fx) * (half + fx)
        shares[3, i] = half * (half - fy) * (half - fy)
        shares[4, i] = most - fy * fy
        shares[5, i] = half * (half + fy) * (half + fy)
        places[i] = (row - np.int32(1)) * width + column - np.int32(1)


@compiled
def _reward(votes: Any, kind: int, pixels: float, events: int) -> float:
    """What the smoothed image is worth; empties the votes."""
    energy, filled = _sums(votes, kind)
    if kind == VARIANCE:
        return float(energy / pixels - (events / pixels) ** 2)
    if kind == GRADIENT:
        return float(energy / pixels)
    empty = 1.0 - filled / pixels
    return float(empty if kind == SUPPRESSED else empty * energy / pixels)


@compiled_fastmath
def _sums(votes: Any, kind: int) -> Any:
    """Sums of h² or |∇h|², and of 1 − e^(−p·h), over the smoothed image; empties the votes."""
    rows, columns = votes.shape
    lines = np.zeros((3, columns), np.float32)
    line, here, above = lines[0], lines[1], lines[2]
    energy = filled = 0.0
    for r in range(1, rows - 1):
        _smooth(votes[r - 1], votes[r], votes[r + 1], line, here)
        votes[r - 1, :] = np.float32(0.0)
        if kind == GRADIENT:
            energy += _gradient_energy(above, here)
        elif kind != SUPPRESSED:
            energy += _energy(here)
        if kind >= SUPPRESSED:
            filled += _accumulated(here)
        here, above = above, here
    return energy, filled


@inlined_fastmath
def _smooth(above: Any, here: Any, below: Any, line: Any, smooth: Any) -> None:
    """Blur a row by the binomial 1 2 1 along both axes; the rim is empty."""
    half, quarter = np.float32(0.5), np.float32(0.25)
    for k in range(line.size):
        line[k] = half * here[k] + quarter * (above[k] + below[k])
    for k in range(1, line.size - 1):
        smooth[k] = half * line[k] + quarter * (line[k - 1] + line[k + 1])


@inlined_fastmath
def _energy(row: Any) -> Any:
    """Sum of h²."""
    total = np.float32(0.0)
    for k in range(row.size):
        total += row[k] * row[k]
    return total


@inlined_fastmath
def _gradient_energy(above: Any, here: Any) -> Any:
    """Sum of |∇h|² by differences of neighbours."""
    total = np.float32(0.0)
    for k in range(here.size - 1):
        across, down = here[k + 1] - here[k], here[k] - above[k]
        total += across * across + down * down
    return total


@inlined
def _accumulated(row: Any) -> float:
    """Sum of 1 − e^(−p·h), to which empty pixels add nothing."""
    total = 0.0
    for k in range(row.size):
        if row[k] > 0.0:
            total += 1.0 - np.exp(-SUPPRESSION * row[k])
    return total
