"""The image of warped events and its sums: the kernels of contrast maximisation.

An event at (x, y, t) is moved back along a candidate velocity v to the middle of the window,
x′ = x − v·t, and voted into an image, which is then smoothed. The image is as large as the warped
events need, so that no event is lost and no candidate gains from moving events out of the image.

One candidate costs one pass over the events and one over the image. The latter smooths each row,
adds it to the sums and clears the votes for the next candidate.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flybench.kernels import compiled, compiled_fastmath, inlined, inlined_fastmath

VARIANCE, GRADIENT, SUPPRESSED, COMBINED = range(4)
"""Kinds of reward; see `detector.contrast_maximisation.warped_events.Reward`."""

SUPPRESSION = 3.0
"""p of the suppressed accumulations. The value in Stoffregen's published code."""

BURST_S = 4e-3
"""Events of a pixel up to this time after another belong to one burst [s]: the spacing of the
events of a sharp edge at 50 px/s, as in `PlaneFitConfig` (assumed)."""

SLACK_S = np.float32(1e-6)
"""Rounding error of a time that stays in the window [s]."""

RIM = 4
"""Width of the empty rim around the warped events [image pixels]. A vote spreads by one pixel, and
by one more if it is rounded up; smoothing spreads by one and leaves out the outermost pixel."""

_BLOCK = 256
"""Number of events whose weights are computed together: few enough for the L1 cache (assumed)."""


@compiled
def rewards_of(
    points: Any, boxes: Any, velocities: Any, scale: Any, kind: int, buffer: Any, found: Any
) -> None:
    """Write the reward of each velocity to `found`.

    `scale` is the number of image pixels per sensor pixel along a side, and in the fixed area.
    """
    for n in range(velocities.shape[0]):
        vx, vy = velocities[n]
        votes = _votes(points, points[2], boxes, vx, vy, scale[0], buffer)
        found[n] = _reward(votes, kind, scale[1], points.shape[1])


@compiled
def rewards_by_order(
    points: Any,
    box: Any,
    velocity: Any,
    orders: Any,
    scale: Any,
    kind: int,
    buffer: Any,
    found: Any,
) -> None:
    """Write the reward of one velocity to `found` for each order of the times of bursts.

    A time that leaves the window comes in at its other end.
    """
    burst, starts = _bursts(points, box)
    times, moved = np.empty_like(points[2]), np.empty_like(starts)
    first, span = np.float32(box[0, 2, 0]), np.float32(box[1, 2, 0] - box[0, 2, 0])
    for n in range(orders.shape[0]):
        taken = 0
        for other in orders[n]:
            if other < starts.size:
                moved[taken] = starts[other] - starts[taken]
                taken += 1
        for i in range(times.size):
            late = points[2, i] + moved[burst[i]] - first
            times[i] = first + (late - span if late > span + SLACK_S else late)
        votes = _votes(points, times, box, velocity[0], velocity[1], scale[0], buffer)
        found[n] = _reward(votes, kind, scale[1], points.shape[1])


@compiled
def _bursts(points: Any, box: Any) -> Any:
    """Return the burst of each event, and the time of the first event of each burst [s]."""
    x0, y0 = box[0, 0, 0], box[0, 1, 0]
    columns, rows = int(box[1, 0, 0] - x0) + 1, int(box[1, 1, 0] - y0) + 1
    latest = np.full(rows * columns, -1, np.int32)
    burst, starts, number = np.empty(points.shape[1], np.int32), np.empty_like(points[2]), 0
    for i in range(burst.size):
        pixel = int(points[1, i] - y0) * columns + int(points[0, i] - x0)
        if latest[pixel] < 0 or points[2, i] - starts[latest[pixel]] > BURST_S:
            latest[pixel] = number
            starts[number] = points[2, i]
            number += 1
        burst[i] = latest[pixel]
    return burst, starts[:number]


@compiled
def smoothed_image(points: Any, boxes: Any, velocity: Any, per_px: float, buffer: Any) -> Any:
    """Return the smoothed image."""
    votes = _votes(points, points[2], boxes, velocity[0], velocity[1], per_px, buffer)
    rows, columns = votes.shape
    image, line = np.zeros_like(votes), np.empty(columns, np.float32)
    for r in range(1, rows - 1):
        _smooth(votes[r - 1], votes[r], votes[r + 1], line, image[r])
    votes[:] = np.float32(0.0)
    return image


@compiled
def _votes(
    points: Any, times: Any, boxes: Any, vx: float, vy: float, per_px: float, buffer: Any
) -> Any:
    """Return the image of warped events before smoothing, in the zeroed buffer."""
    x0, columns = _extent(boxes, 0, vx * per_px, per_px)
    y0, rows = _extent(boxes, 1, vy * per_px, per_px)
    flat = buffer[: rows * columns]
    warp = np.array([per_px, vx * per_px, vy * per_px, x0, y0]).astype(np.float32)
    _vote(points[0], points[1], times, warp, flat, columns)
    return flat.reshape(rows, columns)


@compiled
def _extent(boxes: Any, axis: int, u: float, per_px: float) -> Any:
    """Return the origin and length of the image along an axis, for all warped events.

    The origin is a whole number, so that its place does not affect the rewards; on a sensor with an
    even side, whose middle lies between two pixels, a whole number and a half. The grid is then its
    own mirror image, and its pixels of 1 px are those of the sensor.
    """
    half = 0.5 if boxes[0, axis, 0] - np.floor(boxes[0, axis, 0]) == 0.5 else 0.0
    low, high = np.inf, -np.inf
    for n in range(boxes.shape[2]):
        early, late = u * boxes[0, 2, n], u * boxes[1, 2, n]
        low = min(low, boxes[0, axis, n] * per_px - max(early, late))
        high = max(high, boxes[1, axis, n] * per_px - min(early, late))
    origin = np.floor(low - half) + half - RIM
    return origin, int(high - origin) + RIM + 1


@compiled_fastmath
def _vote(x: Any, y: Any, t: Any, warp: Any, flat: Any, columns: int) -> None:
    """Distribute each event over the nine pixels around it, by a quadratic B-spline on each axis.

    Such a vote has a variance of 1/4 wherever it falls. Bilinear votes have between 0 and 1/4, so
    that contrast would favour velocities that leave events in the middle of pixels: above all a
    component of 0 instead of a slow one.

    Weights are computed for a block of events with SIMD, and then added event by event.
    """
    weights, places = np.empty((6, _BLOCK), np.float32), np.empty(_BLOCK, np.int32)
    for first in range(0, x.size, _BLOCK):
        end = min(first + _BLOCK, x.size)
        _spline_weights(x[first:end], y[first:end], t[first:end], warp, columns, weights, places)
        for i in range(end - first):
            left, middle, right = weights[0, i], weights[1, i], weights[2, i]
            at = places[i]
            for weight in (weights[3, i], weights[4, i], weights[5, i]):
                flat[at] += left * weight
                flat[at + 1] += middle * weight
                flat[at + 2] += right * weight
                at += columns


@inlined_fastmath
def _spline_weights(
    x: Any, y: Any, t: Any, warp: Any, columns: int, weights: Any, places: Any
) -> None:
    """Write the weights of an event's three columns and three rows, and the first pixel's index."""
    per_px, ux, uy, x0, y0 = warp[0], warp[1], warp[2], warp[3], warp[4]
    half, most, width = np.float32(0.5), np.float32(0.75), np.int32(columns)
    for i in range(x.size):
        px, py = x[i] * per_px - ux * t[i] - x0, y[i] * per_px - uy * t[i] - y0
        column, row = np.int32(px + half), np.int32(py + half)
        fx, fy = px - np.float32(column), py - np.float32(row)
        weights[0, i] = half * (half - fx) * (half - fx)
        weights[1, i] = most - fx * fx
        weights[2, i] = half * (half + fx) * (half + fx)
        weights[3, i] = half * (half - fy) * (half - fy)
        weights[4, i] = most - fy * fy
        weights[5, i] = half * (half + fy) * (half + fy)
        places[i] = (row - np.int32(1)) * width + column - np.int32(1)


@compiled
def _reward(votes: Any, kind: int, pixels: float, events: int) -> float:
    """Return the reward of the smoothed image, and clear the votes."""
    energy, filled = _sums(votes, kind)
    if kind == VARIANCE:
        return float(energy / pixels - (events / pixels) ** 2)
    if kind == GRADIENT:
        return float(energy / pixels)
    empty = 1.0 - filled / pixels
    return float(empty if kind == SUPPRESSED else empty * energy / pixels)


@compiled_fastmath
def _sums(votes: Any, kind: int) -> Any:
    """Sum h² or |∇h|², and 1 − e^(−p·h), over the smoothed image, and clear the votes."""
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
            filled += _filled(here)
        here, above = above, here
    return energy, filled


@inlined_fastmath
def _smooth(above: Any, here: Any, below: Any, line: Any, smooth: Any) -> None:
    """Smooth a row by the binomial filter 1 2 1 along both axes; the rim stays empty."""
    half, quarter = np.float32(0.5), np.float32(0.25)
    for k in range(line.size):
        line[k] = half * here[k] + quarter * (above[k] + below[k])
    for k in range(1, line.size - 1):
        smooth[k] = half * line[k] + quarter * (line[k - 1] + line[k + 1])


@inlined_fastmath
def _energy(row: Any) -> Any:
    """Return the sum of h² over a row."""
    total = np.float32(0.0)
    for k in range(row.size):
        total += row[k] * row[k]
    return total


@inlined_fastmath
def _gradient_energy(above: Any, here: Any) -> Any:
    """Return the sum of |∇h|² over a row, from differences of neighbours."""
    total = np.float32(0.0)
    for k in range(here.size - 1):
        across, down = here[k + 1] - here[k], here[k] - above[k]
        total += across * across + down * down
    return total


@inlined
def _filled(row: Any) -> float:
    """Return the sum of 1 − e^(−p·h) over a row; empty pixels add nothing."""
    total = 0.0
    for k in range(row.size):
        if row[k] > 0.0:
            total += 1.0 - np.exp(-SUPPRESSION * row[k])
    return total
