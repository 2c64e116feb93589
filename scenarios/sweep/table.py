"""The results as one tidy table: a row a point, with every parameter."""

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


def rows(points: Sequence[Point], results: Sequence[Results]) -> list[Row]:
    """A row a point: labels, parameters, truth, events and what the detector achieved.

    All have the same columns; a value is None where there is none, such as the fly's parameters
    of another detector.
    """
    known = [_known(point) for point in points]
    labels = dict.fromkeys(name for point in points for name in point.labels)
    given = set().union(*known)
    parameters = [name for name in parameter_types() if name in given]
    found = dict.fromkeys(name for result in results for name in result)
    columns = dict.fromkeys([*labels, *parameters, *found])
    made = [
        dict(point.labels) | own | dict(result)
        for point, own, result in zip(points, known, results, strict=True)
    ]
    return [{name: _plain(row.get(name)) for name in columns} for row in made]


def _known(point: Point) -> dict[str, object]:
    return {name: v for name, v in point.config.parameters().items() if name in parameter_types()}


def _plain(value: Any) -> Any:
    """What CSV and Parquet both hold: a list becomes its JSON."""
    if isinstance(value, StrEnum):
        return value.value
    return json.dumps(value) if isinstance(value, list | tuple) else value


def write_csv(path: Path, table: Sequence[Row]) -> None:
    """Write as CSV, with an empty cell for None."""
    write_table(path, tuple(table[0]), (tuple(row.values()) for row in table))


def write_parquet(path: Path, table: Sequence[Row]) -> None:
    """Write as Parquet; a column without any value is one of numbers."""
    columns = {name: pa.array([row[name] for row in table]) for name in table[0]}
    for name, column in columns.items():
        if pa.types.is_null(column.type):
            columns[name] = column.cast(pa.float64())
    pq.write_table(pa.table(columns), path)
