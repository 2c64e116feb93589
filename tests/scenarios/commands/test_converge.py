"""The command `flybench converge`."""

import csv
from pathlib import Path

import pytest

from scenarios.commands import converge
from scenarios.commands.converge import Converge
from scenarios.convergence.measure import COLUMNS, Rendering
from scenarios.errors import ScenarioError

RENDERINGS = (Rendering("full", 2, 0.5), Rendering("keyframes", 1, 0.5, 8.0))


def test_the_table_is_printed_and_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(converge, "RENDERINGS", RENDERINGS)
    assert Converge(lighting="day", piece_px=1.0, out=tmp_path / "out").execute() == 0
    printed = capsys.readouterr().out
    assert "day full 2×2" in printed
    assert "day keyframes" in printed
    with (tmp_path / "out" / "convergence.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == ("lighting", *COLUMNS)
    assert [row["rendering"] for row in rows] == ["full", "keyframes"]


def test_a_piece_that_is_too_long_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"--piece-px is 100\. Allowed is a number from 1"):
        Converge(piece_px=100.0).execute()
