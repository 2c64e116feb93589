"""The table of results, as CSV and as Parquet."""

import csv
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq

from scenarios.pipeline.run_config import RunConfig
from scenarios.sweep.plan import Point
from scenarios.sweep.table import make_rows, write_csv, write_parquet

FLY = RunConfig()
POINTS = [
    Point(replace(FLY, method="plane-fit", fly=None), {"clutter": "calm"}),
    Point(FLY, {"clutter": "busy"}),
]
RESULTS = [
    {"events.count": 3, "detector.accuracy": 0.1, "detector.latency_ms": None},
    {"events.count": 4, "detector.accuracy": 1 / 3, "detector.latency_ms": None},
]
TABLE = make_rows(POINTS, RESULTS)


def test_columns_are_labels_then_parameters_then_results() -> None:
    names = list(TABLE[0])
    assert names == list(TABLE[1])
    assert names[0] == "clutter"
    assert names[1:-3] == list(FLY.parameters())
    assert names[-3:] == ["events.count", "detector.accuracy", "detector.latency_ms"]


def test_a_missing_value_is_none() -> None:
    assert TABLE[0]["fly.alpha"] is None
    assert TABLE[1]["fly.alpha"] == 0.5
    assert TABLE[1]["fly.further_delays_us"] == "[]"
    assert TABLE[1]["crossing.distance_m"] == 6.89


def test_both_files_hold_the_same_values(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv", TABLE)
    write_parquet(tmp_path / "a.parquet", TABLE)
    assert pq.read_table(tmp_path / "a.parquet").to_pylist() == TABLE
    with (tmp_path / "a.csv").open(newline="") as file:
        read = list(csv.DictReader(file))
    expected = [{k: "" if v is None else str(v) for k, v in row.items()} for row in TABLE]
    assert read == expected


def test_parquet_columns_have_the_right_types(tmp_path: Path) -> None:
    write_parquet(tmp_path / "a.parquet", TABLE)
    schema = pq.read_schema(tmp_path / "a.parquet")
    for name, kind in [
        ("crossing.omega_rad_s", "double"),
        ("crossing.street_seed", "int64"),
        ("sensor.aps.noise", "bool"),
        ("detector.latency_ms", "double"),
        ("crossing.direction", "string"),
    ]:
        assert str(schema.field(name).type) == kind
