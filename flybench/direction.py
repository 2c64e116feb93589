"""The directions of image motion, and the convention for their angles."""

from __future__ import annotations

from enum import StrEnum


class Direction(StrEnum):
    """One of the four cardinal directions of image motion, or none.

    In the image frame x points right and y points down. An angle of 0° points right and +90° points
    down; no other place states this convention.
    """

    RIGHT = "right"
    LEFT = "left"
    UP = "up"
    DOWN = "down"
    NONE = "none"

    @property
    def angle_deg(self) -> float | None:
        """Angle of the direction in (−180, 180] [deg]; None for `NONE`."""
        return _ANGLES_DEG[self]


CARDINAL = (Direction.RIGHT, Direction.LEFT, Direction.UP, Direction.DOWN)
"""The directions of motion, without `NONE`."""

_ANGLES_DEG: dict[Direction, float | None] = {
    Direction.RIGHT: 0.0,
    Direction.DOWN: 90.0,
    Direction.LEFT: 180.0,
    Direction.UP: -90.0,
    Direction.NONE: None,
}
