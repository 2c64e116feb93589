"""The command `flybench denoise`."""

import csv
import json
from pathlib import Path

import pytest

from scenarios.commands.data.denoise import Denoise, lighting_at
from scenarios.errors import MethodError, ScenarioError
from scenarios.options.sensor import SensorOptions
from sim import Lighting


def quick(out: Path, **options: object) -> Denoise:
    chosen = {"lux": (3.0, 30_000.0), "methods": ("plane-fit",), "filters": ("baf", "stcf")}
    return Denoise(
        omega_rad_s=3.0,
        step_px=8.0,
        supersample=1,
        out=out,
        **(chosen | options),  # type: ignore[arg-type]
    )


def read(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_filters_and_detectors_are_measured_by_illuminance(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert quick(tmp_path / "out").execute() == 0
    printed = capsys.readouterr().out
    for words in ("AUC", "right steps", "stcf", "30000", "plane fit"):
        assert words in printed
    filters = read(tmp_path / "out" / "filters.csv")
    assert [(row["illuminance_lux"], row["filter"]) for row in filters] == [
        ("3.0", "baf"),
        ("3.0", "stcf"),
        ("30000.0", "baf"),
        ("30000.0", "stcf"),
    ]
    assert [row["lighting"] for row in filters] == ["night", "night", "day", "day"]
    assert all(0.5 < float(row["auc"]) <= 1 for row in filters)
    assert all(float(row["kept_signal"]) > float(row["kept_noise"]) for row in filters)
    assert float(filters[0]["noise_share"]) > float(filters[2]["noise_share"]) > 0
    steps = read(tmp_path / "out" / "steps.csv")
    assert [row["filter"] for row in steps] == ["none", "baf", "stcf"] * 2
    assert len({row["grms"] for row in steps}) > 3  # a filter changes what the detector sees
    curves = read(tmp_path / "out" / "roc.csv")
    assert {row["filter"] for row in curves} == {"baf", "stcf"}
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert {"roc.png", "roc.svg", "steps.png", "steps.svg"} <= set(summary["files"])


def test_bad_input_is_refused_before_anything_is_rendered(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(ScenarioError, match=r"--lux is empty\. Allowed is one value or more"):
        quick(out, lux=()).execute()
    with pytest.raises(ScenarioError, match=r"--filters is baf baf\. Allowed is one value"):
        quick(out, filters=("baf", "baf")).execute()
    with pytest.raises(ScenarioError, match=r"--methods has stcf\+fly\. Allowed are detectors"):
        quick(out, methods=("stcf+fly",)).execute()
    with pytest.raises(MethodError, match="The method is 'flea'"):
        quick(out, methods=("flea",)).execute()
    assert list(tmp_path.iterdir()) == []


def test_a_stream_without_noise_is_named(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"events are signal\. Allowed are streams with signal"):
        quick(
            tmp_path / "out", sensor=SensorOptions(set=("preset=ideal",)), lux=(30_000.0,)
        ).execute()
    assert not (tmp_path / "out").exists()


def test_the_time_of_day_follows_the_illuminance() -> None:
    assert [lighting_at(lux) for lux in (1, 39.9, 40, 999, 1000)] == [
        Lighting.NIGHT,
        Lighting.NIGHT,
        Lighting.DUSK,
        Lighting.DUSK,
        Lighting.DAY,
    ]
