"""Options of a command that reads a recording."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flybench.events import EVENT_DTYPE
from formats import FormatError
from scenarios.errors import ScenarioError
from scenarios.options.recording import RecordingOptions

EVENTS = np.zeros(1000, EVENT_DTYPE)
EVENTS["t"] = np.arange(1000) * 100
EVENTS["x"] = np.arange(1000) % 346
EVENTS["y"] = np.arange(1000) * 7 % 260
EVENTS["p"] = np.arange(1000) % 2


def save_late(path: Path) -> None:
    """Write a table in which event 500 is 3 ms late."""
    late = EVENTS.copy()
    late["t"][500] -= 3000
    np.save(path, np.stack([late[name].astype(int) for name in "xytp"], axis=1))


def test_the_options_reach_the_reader(tmp_path: Path) -> None:
    save_late(tmp_path / "a.npy")
    options = RecordingOptions(size="346x260", columns="xytp", time_unit="us")
    with replace(options, sort=3.5).open(tmp_path / "a.npy") as file:
        assert sum(chunk.events.size for chunk in file) == 1000
        assert (file.width, file.height) == (346, 260)
        assert (file.sorted_events, file.dropped_events) == (1, None)
    with replace(options, sort=2.0, drop_unsorted=True).open(tmp_path / "a.npy") as file:
        assert sum(chunk.events.size for chunk in file) == 999
        assert (file.sorted_events, file.dropped_events) == (0, 1)
    with options.open(tmp_path / "a.npy") as file, pytest.raises(FormatError, match="--sort 3,"):
        list(file)


@pytest.mark.parametrize(
    "changes", [{"sort": 0.0}, {"sort": -1.0}, {"sort": 1e9}, {"sort": float("nan")}]
)
def test_a_wrong_time_to_sort_is_refused(tmp_path: Path, changes: Any) -> None:
    with pytest.raises(ScenarioError, match=r"--sort is .* Allowed is a time above 0"):
        RecordingOptions(**changes).open(tmp_path / "a.npy")


def test_what_is_uncertain_is_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    events = EVENTS.copy()
    events["t"] = np.repeat(np.arange(100), 10)
    np.save(tmp_path / "a.npy", events)
    with RecordingOptions().open(tmp_path / "a.npy"):
        pass
    err = capsys.readouterr().err
    assert err.startswith("flybench: warning: ")
    assert "--time-unit: the time of a frame" in err
