"""Where the rows of a grid cross a triangle, reckoned alike for triangles that share an edge."""

from __future__ import annotations

from flybench.kernels import inlined

Six = tuple[float, float, float, float, float, float]


@inlined
def from_top(ax: float, ay: float, bx: float, by: float, cx: float, cy: float) -> Six:
    """A triangle's corners from top to bottom.

    Two triangles that share an edge so reckon it alike; else cracks would open between them.
    """
    if by < ay:
        ax, ay, bx, by = bx, by, ax, ay
    if cy < ay:
        ax, ay, cx, cy = cx, cy, ax, ay
    if cy < by:
        bx, by, cx, cy = cx, cy, bx, by
    return ax, ay, bx, by, cx, cy


@inlined
def slopes(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float
) -> tuple[float, float, float]:
    """Columns a row of the edges from top to bottom, from top to middle, from there to bottom."""
    return (cx - ax) / (cy - ay), (bx - ax) / (by - ay), (cx - bx) / (cy - by)


@inlined
def crossings(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    whole: float,
    upper: float,
    lower: float,
    y: float,
) -> tuple[float, float]:
    """Where a row enters a triangle and leaves it.

    Args:
        ax: of its topmost corner.
        ay: likewise.
        bx: of its middle one.
        by: likewise.
        whole: as `slopes` has them, and so the next two.
        upper: likewise.
        lower: likewise.
        y: of the row, between the topmost corner and the lowest.
    """
    one = ax + (y - ay) * whole
    other = ax + (y - ay) * upper if y < by else bx + (y - by) * lower
    return min(one, other), max(one, other)
