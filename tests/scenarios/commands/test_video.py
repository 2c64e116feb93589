"""`flybench video`: a film of a recording of events, and its errors."""

from pathlib import Path

import av
import numpy as np
import pytest

from flybench.events import EVENT_DTYPE
from formats import write_events
from scenarios.commands.viewing.video import Video
from scenarios.errors import OutputError, ScenarioError
from scenarios.output.terminal import execute


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """Write a bar that moves right for 0.2 s at 400 px/s."""
    rows = np.arange(100, 160)
    events = np.zeros(80 * rows.size, EVENT_DTYPE)
    events["t"] = np.repeat(np.arange(80) * 2500, rows.size)
    events["x"] = np.repeat(np.arange(80) + 50, rows.size)
    events["y"], events["p"] = np.tile(rows, 80), True
    path = tmp_path / "bar.npz"
    write_events(path, [events], width=346, height=260)
    return path


def test_a_recording_of_events_becomes_a_film(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "film.gif"
    command = Video((recording,), out, speed=0.1, to_s=0.1, fps=10, method="fly", scale=1)
    assert execute(command) == 0
    assert "film.gif: 11 frames, 1.1 s" in capsys.readouterr().out
    with av.open(str(out)) as container:
        assert sum(1 for _ in container.decode(video=0)) == 11
    assert execute(command) == 2  # it exists
    assert "--overwrite" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"speed": 0.0}, r"--speed is 0\.0"),
        ({"fps": 51}, r"--fps is 51.*1 to 50"),
        ({"scale": 0}, "--scale is 0"),
        ({"window_ms": 0.0}, "--window-ms is 0"),
        ({"from_s": -1.0}, "--from is -1"),
        ({"from_s": 9.0}, "no event between"),
        ({"recording": "day"}, "--recording is day"),
    ],
)
def test_wrong_options_are_refused_and_nothing_is_written(
    recording: Path, tmp_path: Path, options: dict[str, float], message: str
) -> None:
    out = tmp_path / "film.gif"
    with pytest.raises(ScenarioError, match=message):
        Video((recording,), out, **options).execute()  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == [recording]


def test_the_ending_states_the_format(recording: Path, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"ends in \.mp4 or \.gif"):
        Video((recording,), tmp_path / "film.avi").execute()


def test_a_film_does_not_replace_its_source(recording: Path, tmp_path: Path) -> None:
    source = recording.rename(tmp_path / "bar.gif")
    with pytest.raises(OutputError, match="a file to read"):
        Video((source,), source, overwrite=True).execute()


def test_a_recording_is_needed(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="No recording is given"):
        Video((), tmp_path / "film.gif").execute()
