"""The results of a sweep as one tidy table: one row per point, with every parameter."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from scenarios.output.tables import write_table
from scenarios.sweep.measure import Results
from scenarios.sweep.parameters import parameter_types
from scenarios.sweep.plan import Point

Row = Mapping[str, Any]


def make_rows(points: Sequence[Point], results: Sequence[Results]) -> list[Row]:
    """Return one row per point: labels, parameters, truth, events and scores.

    All rows have the same columns. A value is None if a point has none, such as the fly's
    parameters for another detector.
    """
    values = [_parameters(point) for point in points]
    labels = dict.fromkeys(name for point in points for name in point.labels)
    used = set().union(*values)
    parameters = [name for name in parameter_types() if name in used]
    scores = dict.fromkeys(name for result in results for name in result)
    columns = dict.fromkeys([*labels, *parameters, *scores])
    rows = [
        dict(point.labels) | own | dict(result)
        for point, own, result in zip(points, values, results, strict=True)
    ]
    return [{name: _plain(row.get(name)) for name in columns} for row in rows]


def _parameters(point: Point) -> dict[str, object]:
    return {name: v for name, v in point.config.parameters().items() if name in parameter_types()}


def _plain(value: Any) -> Any:
    """Return a value that CSV and Parquet can both hold; a list becomes JSON."""
    if isinstance(value, StrEnum):
        return value.value
    return json.dumps(value) if isinstance(value, list | tuple) else value


def write_csv(path: Path, table: Sequence[Row]) -> None:
    """Write the table as CSV; None becomes an empty cell."""
    write_table(path, tuple(table[0]), (tuple(row.values()) for row in table))


def write_parquet(path: Path, table: Sequence[Row]) -> None:
    """Write the table as Parquet; a column without values gets the type float64."""
    columns = {name: pa.array([row[name] for row in table]) for name in table[0]}
    for name, column in columns.items():
        if pa.types.is_null(column.type):
            columns[name] = column.cast(pa.float64())
    with path.open("wb") as file:  # Arrow's own files do not say that the disk is full
        pq.write_table(pa.table(columns), file)
