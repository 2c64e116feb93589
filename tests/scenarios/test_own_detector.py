"""The README's example of a detector of one's own, run as it stands there."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from flybench.direction import CARDINAL
from scenarios.envelope.measure import measure
from scenarios.envelope.stimulus import Stimulus

EXAMPLE = '''\
import numpy as np
from detector.estimate import Direction, MotionEstimate

class MedianDrift:
    """Where the median of the events goes from one 20 ms to the next."""
    def __init__(self, *, width: int, height: int) -> None:
        self.waiting, self.t_us, self.centre = [], 0, np.array([width, height]) / 2
    def push(self, events):  # arrays of t [µs], x, y, p, sorted, in chunks of any size
        self.waiting.append(events)
        return self.advance(int(events["t"][-1])) if events.size else []
    def advance(self, t_us):  # every event before t_us is here: say what is due
        return [self.estimate() for _ in range(self.t_us + 20_000, t_us + 1, 20_000)]
    def estimate(self):
        events, before, self.t_us = np.concatenate(self.waiting), self.centre, self.t_us + 20_000
        now, self.waiting = events[events["t"] < self.t_us], [events[events["t"] >= self.t_us]]
        self.centre = np.array([np.median(now[k]) for k in "xy"]) if now.size else before
        hs, vs = np.tanh((self.centre - before) / 20)  # right and down are positive
        ways = {hs: Direction.RIGHT, -hs: Direction.LEFT, vs: Direction.DOWN, -vs: Direction.UP}
        way = ways[max(ways)] if max(ways) > 0.02 else Direction.NONE
        return MotionEstimate(self.t_us, hs, vs, way, max(ways), (hs, vs), tuple(self.centre), None)
'''
METHOD = "my_detector:MedianDrift"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "my_detector.py").write_text(EXAMPLE)
    monkeypatch.delitem(sys.modules, "my_detector", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def test_it_is_short() -> None:
    assert len(EXAMPLE.strip().splitlines()) <= 20


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("direction", CARDINAL)
def test_it_works(direction: str) -> None:
    (row,) = measure(Stimulus(speed_px_s=500, direction=direction), [METHOD])  # type: ignore[arg-type]
    assert row["verdict"] == direction
    assert row["accuracy_after_100ms"] > 0.9
    assert row["roi_iou"] is None


def test_a_command_takes_it(folder: Path) -> None:
    coarse = ["--step-px", "8", "--supersample", "1", "--omega", "2.42", "--lead-s", "0.05"]
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
