"""Tables of ground truth and estimates as CSV files."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from detector.estimate import MotionEstimate
from sim import GroundTruth

TRUTH_COLUMNS = (
    "t_us",
    "direction",
    "angular_velocity_rad_s",
    "image_velocity_x_px_s",
    "image_velocity_y_px_s",
    "position_m",
    "visibility",
    "box_x0_px",
    "box_y0_px",
    "box_x1_px",
    "box_y1_px",
    "centroid_x_px",
    "centroid_y_px",
)
ESTIMATE_COLUMNS = ("t_us", "hs", "vs", "direction", "strength", "response_hs", "response_vs")


def truth_row(truth: GroundTruth) -> Sequence[Any]:
    """Return the values of `TRUTH_COLUMNS`; box and centroid may be empty."""
    box = truth.bounding_box_px or ("",) * 4
    centroid = ("", "") if truth.centroid_px is None else truth.centroid_px.round(3)
    return (
        truth.t_us,
        truth.direction.value,
        truth.angular_velocity_rad_s,
        *truth.image_velocity_px_s,
        truth.position_m,
        truth.visibility,
        *box,
        *centroid,
    )


def estimate_row(estimate: MotionEstimate) -> Sequence[Any]:
    """Return the values of `ESTIMATE_COLUMNS`."""
    e = estimate
    return e.t_us, e.hs, e.vs, e.direction.value, e.strength, *e.response


def write_table(path: Path, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write a CSV file with one header row."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(rows)
