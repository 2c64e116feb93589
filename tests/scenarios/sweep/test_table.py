"""One tidy table, as CSV and as Parquet."""

import csv
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq

from scenarios.pipeline.run_config import RunConfig
from scenarios.sweep.plan import Point
from scenarios.sweep.table import rows, write_csv, write_parquet

FLY = RunConfig()
POINTS = [
    Point(replace(FLY, method="plane-fit", fly=None), {"clutter": "calm"}),
    Point(FLY, {"clutter": "busy"}),
]
RESULTS = [
    {"events.count": 3, "detector.accuracy": 0.1, "detector.latency_ms": None},
    {"events.count": 4, "detector.accuracy": 1 / 3, "detector.latency_ms": None},
]
TABLE = rows(POINTS, RESULTS)


def test_labels_come_first_then_parameters_in_their_order_then_results() -> None:
    names = list(TABLE[0])
    assert names == list(TABLE[1])
    assert names[0] == "clutter"
    assert names[1:-3] == list(FLY.parameters())
    assert names[-3:] == ["events.count", "detector.accuracy", "detector.latency_ms"]


def test_what_a_point_has_not_is_empty() -> None:
    assert TABLE[0]["fly.alpha"] is None
    assert TABLE[1]["fly.alpha"] == 0.5
    assert TABLE[1]["fly.further_delays_us"] == "[]"
    assert TABLE[1]["crossing.distance_m"] == 6.89


def test_both_files_hold_the_same(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv", TABLE)
    write_parquet(tmp_path / "a.parquet", TABLE)
    assert pq.read_table(tmp_path / "a.parquet").to_pylist() == TABLE
    with (tmp_path / "a.csv").open(newline="") as file:
        read = list(csv.DictReader(file))
    said = [{k: "" if v is None else str(v) for k, v in row.items()} for row in TABLE]
    assert read == said


def test_a_column_of_numbers_is_one_in_parquet(tmp_path: Path) -> None:
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
