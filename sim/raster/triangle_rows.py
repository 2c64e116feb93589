"""Intersections of grid rows with a triangle.

Triangles that share an edge get the same intersections with it, so that no gaps open between them.
"""

from __future__ import annotations

from flybench.kernels import inlined

CornersXY = tuple[float, float, float, float, float, float]


@inlined
def sort_corners_by_row(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float
) -> CornersXY:
    """Return a triangle's corners, sorted from top to bottom.

    The order makes two triangles that share an edge compute it in the same way. Otherwise gaps
    would open between them.
    """
    if by < ay:
        ax, ay, bx, by = bx, by, ax, ay
    if cy < ay:
        ax, ay, cx, cy = cx, cy, ax, ay
    if cy < by:
        bx, by, cx, cy = cx, cy, bx, by
    return ax, ay, bx, by, cx, cy


@inlined
def edge_slopes(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float
) -> tuple[float, float, float]:
    """Return the edges' slopes in columns per row: top-bottom, top-middle and middle-bottom."""
    return (cx - ax) / (cy - ay), (bx - ax) / (by - ay), (cx - bx) / (cy - by)


@inlined
def row_span(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    long_slope: float,
    upper_slope: float,
    lower_slope: float,
    y: float,
) -> tuple[float, float]:
    """Return the columns at which a row enters and leaves a triangle.

    Args:
        ax: column of the topmost corner.
        ay: row of the topmost corner.
        bx: column of the middle corner.
        by: row of the middle corner.
        long_slope: slope of the edge from top to bottom, from `edge_slopes`.
        upper_slope: slope of the edge from top to middle.
        lower_slope: slope of the edge from middle to bottom.
        y: coordinate of the row, between those of the topmost and the lowest corner.
    """
    one = ax + (y - ay) * long_slope
    other = ax + (y - ay) * upper_slope if y < by else bx + (y - by) * lower_slope
    return min(one, other), max(one, other)
