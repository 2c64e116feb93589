"""Direction, angular velocity and image velocity of every moving object, as a table."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from scenarios.output.tables import write_table
from sim import GroundTruth

COLUMNS = (
    "t_us",
    "track_id",
    "name",
    "kind",
    "direction",
    "angular_velocity_rad_s",
    "image_velocity_x_px_s",
    "image_velocity_y_px_s",
    "reference_x_px",
    "reference_y_px",
    "distance_m",
    "visibility",
)


class MotionTable:
    """Rows of `motion.csv`: one for each label and object."""

    def __init__(self) -> None:
        self._rows: list[tuple[Any, ...]] = []

    def add(self, truth: GroundTruth) -> None:
        """Add the objects of one label; only the target has a direction, which is constant."""
        for item in truth.objects:
            self._rows.append(
                (
                    truth.t_us,
                    item.number,
                    item.name,
                    item.kind,
                    truth.direction.value if item is truth.target else "",
                    item.angular_velocity_rad_s,
                    *map(float, item.image_velocity_px_s),
                    *map(float, item.reference_px),
                    item.distance_m,
                    item.visibility,
                )
            )

    def write(self, path: Path) -> None:
        """Write the table."""
        write_table(path, COLUMNS, self._rows)
