"""The example of a user's detector in docs/reference/own-detector.md."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from flybench.direction import CARDINAL
from scenarios.envelope.measure import measure
from scenarios.envelope.stimulus import Stimulus

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "own-detector.md"
(EXAMPLE,) = re.findall(
    r"^```python\n((?:(?!^```).)*?class MedianDrift.*?)^```$",
    PAGE.read_text(encoding="utf-8"),
    re.DOTALL | re.MULTILINE,
)
METHOD = "my_detector:MedianDrift"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "my_detector.py").write_text(EXAMPLE)
    monkeypatch.delitem(sys.modules, "my_detector", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def test_the_example_is_short() -> None:
    assert len([line for line in EXAMPLE.splitlines() if line]) <= 20


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("direction", CARDINAL)
def test_the_example_finds_every_direction(direction: str) -> None:
    (row,) = measure(Stimulus(speed_px_s=500, direction=direction), [METHOD])  # type: ignore[arg-type]
    assert row["verdict"] == direction
    assert row["accuracy_after_100ms"] > 0.9
    assert row["roi_iou"] is None


def test_flybench_run_accepts_the_example(folder: Path) -> None:
    coarse = ["--step-px", "8", "--supersample", "1", "--omega", "4", "--lead-s", "0.05"]
    flybench = str(Path(sys.executable).with_name("flybench"))
    command = [flybench, "run", "--method", METHOD, *coarse, "--out", "out"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert METHOD in done.stdout
    summary = json.loads((folder / "out" / "summary.json").read_text())
    assert summary["detector"]["method"] == summary["parameters"]["method"] == METHOD
    assert summary["detector"]["direction"] == "right"
    assert "fly" not in summary
    assert summary["parameters"]["fly"] is None
    assert (folder / "out" / "recording.rrd").stat().st_size > 100_000
