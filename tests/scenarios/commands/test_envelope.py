"""The command `flybench envelope`."""

import csv
import json
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from scenarios.commands.envelope import Envelope
from scenarios.envelope.grid import LEVELS
from scenarios.errors import MethodError, OutputError, ScenarioError
from tests.scenarios.in_process import exit_status

SMALL = [
    *("--speeds", "2000", "--noises", "0.5", "1", "--seeds", "1"),
    *("--cross", "direction", "--only", "contrast", "--jobs", "1"),
]


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    folder = tmp_path_factory.mktemp("envelope") / "out"
    methods = ("--method", "fly", "--method", "wide")
    with redirect_stdout(StringIO()) as printed:
        assert exit_status(["envelope", *methods, *SMALL, "--out", str(folder)]) == 0
    return folder, printed.getvalue()


def test_the_folder_holds_table_maps_and_summary(ran: tuple[Path, str]) -> None:
    folder, _ = ran
    names = {path.name for path in folder.iterdir()}
    drawn = {"fly", "fly_opposite", "fly_none", "wide", "wide_opposite", "wide_none"}
    drawn |= {"comparison", "by_direction"}
    figures = {f"{name}.{kind}" for name in drawn for kind in ("png", "svg")}
    assert names == figures | {"envelope.csv", "summary.json"}
    summary = json.loads((folder / "summary.json").read_text())
    assert set(summary["files"]) == names
    assert set(summary["holds"]) == {"fly", "wide"}
    assert summary["parameters"]["method"] == ["fly", "wide"]
    assert summary["grid"]["speeds_px_s"] == [2000]


def test_the_table_has_one_row_per_stimulus_and_method(ran: tuple[Path, str]) -> None:
    with (ran[0] / "envelope.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    points = 2 * 4 + 3  # noise × direction, and the other contrasts
    assert len(rows) == 2 * points
    assert {row["method"] for row in rows} == {"fly", "wide"}
    assert {float(row["contrast"]) for row in rows} == {0.1, 0.2, 0.4, 0.8}
    mid_contrast = [row for row in rows if row["method"] == "fly" and row["contrast"] == "0.4"]
    fly = [float(row["accuracy_after_100ms"]) for row in mid_contrast]
    assert sum(fly) / len(fly) > 0.9


def test_the_printed_table_has_methods_and_operating_ranges(ran: tuple[Path, str]) -> None:
    for words in ("fly: correct steps", "wide: correct steps", "at least 95 % correct at 0.5 Hz"):
        assert words in " ".join(ran[1].split())


def test_an_envelope_replaces_an_earlier_one_but_no_other_folder(ran: tuple[Path, str]) -> None:
    folder, _ = ran
    again = Envelope(
        speeds=(2000,), noises=(1,), seeds=1, cross=(), only=("surface",), jobs=1, out=folder
    )
    assert again.execute() == 0
    assert not (folder / "wide.png").exists()
    (folder / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match="were not written by flybench"):
        Envelope(out=folder).execute()


def test_invalid_arguments_are_refused_before_anything_is_measured(tmp_path: Path) -> None:
    with pytest.raises(MethodError, match="Allowed is fly"):
        Envelope(method=("fly", "bee"), out=tmp_path / "out").execute()
    with pytest.raises(ScenarioError, match="frame-fly looks at frames"):
        Envelope(method=("frame-fly",), out=tmp_path / "out").execute()
    with pytest.raises(ScenarioError, match=r"speed_px_s is -5\.0"):
        Envelope(speeds=(-5.0,), out=tmp_path / "out").execute()
    with pytest.raises(ScenarioError, match=r"jobs is 0\. Allowed is 1 or more"):
        Envelope(jobs=0, out=tmp_path / "out").execute()
    assert list(tmp_path.iterdir()) == []


def test_full_draws_every_point_more_often() -> None:
    assert Envelope().grid().seeds == 2
    assert Envelope(full=True).grid().seeds == 10
    assert Envelope(full=True, seeds=3).grid().seeds == 3
    assert set(Envelope().grid().levels) == set(LEVELS)
    assert Envelope(method=("wide", "wide")).methods == ("wide",)
    assert Envelope().methods == ("fly",)
