"""Windows of recordings: their events and frames, in time and place."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flybench.direction import Direction
from flybench.events import EVENT_DTYPE, Events
from flybench.memory import VARIABLE, MemoryBudgetError, free_bytes
from formats import open_events
from scenarios.validate.keys import ManifestError
from scenarios.validate.manifest import Recording, Window
from scenarios.validate.stimulus import check_recording, read_stimuli
from tests.scenarios.validate.made_recordings import HEIGHT, WIDTH, write_recording


def ramp() -> Events:
    """Return one event every ms for 0.3 s, at x = number, y = number modulo 260."""
    events = np.zeros(300, EVENT_DTYPE)
    events["t"] = np.arange(300) * 1000
    events["x"], events["y"] = np.arange(300), np.arange(300) % HEIGHT
    return events


def read(tmp_path: Path, *windows: Window, file: str = "a.aedat4", frames: int = 6) -> Any:
    write_recording(tmp_path / file, ramp(), frames)
    return read_stimuli(
        Recording("made", file, "", "", "", windows, size=(WIDTH, HEIGHT)), tmp_path / file
    )


def test_a_window_holds_the_events_and_frames_of_its_time(tmp_path: Path) -> None:
    first, second = read(
        tmp_path,
        Window(Direction.RIGHT, 100_000, 200_000),
        Window(Direction.LEFT, 60_000, 115_000),
    )
    assert first.events["x"].tolist() == list(range(100, 200))
    assert (first.events["t"][0], first.events["t"][-1]) == (0, 99_000)
    assert first.duration_us == 100_000
    assert [(f.start_us, f.end_us) for f in first.frames] == [(10_000, 15_000), (60_000, 65_000)]
    assert [(f.start_us, f.end_us) for f in second.frames] == [(0, 5000), (50_000, 55_000)]
    assert second.events["x"].tolist() == list(range(60, 115))


def test_a_recording_may_state_its_unit_and_columns(tmp_path: Path) -> None:
    rows = [[1, x % 2, 5, x, x] for x in range(200)]
    np.savetxt(tmp_path / "a.txt", rows, fmt="%d")
    made = Recording("made", "a.txt", "", "", "", (Window(Direction.NONE),), size=(WIDTH, HEIGHT))
    stated = replace(made, time_unit="1/100s", columns="-pyxt")
    (found,) = read_stimuli(stated, tmp_path / "a.txt")
    assert found.events["t"].tolist() == list(range(0, 2_000_000, 10_000))
    assert found.events["x"].tolist() == list(range(200))


def test_a_frame_that_leaves_the_window_does_not_count(tmp_path: Path) -> None:
    (found,) = read(tmp_path, Window(Direction.RIGHT, 61_000, 114_000))
    assert found.frames == ()


def test_a_window_without_times_is_the_whole_recording(tmp_path: Path) -> None:
    (found,) = read(tmp_path, Window(Direction.NONE))
    assert found.events.size == 300
    assert found.duration_us == 299_001
    assert (found.width, found.height) == (WIDTH, HEIGHT)
    assert len(found.frames) == 6


def test_a_crop_is_a_sensor_of_its_own(tmp_path: Path) -> None:
    (found,) = read(tmp_path, Window(Direction.UP, crop=(100, 50, 120, 260)))
    assert (found.width, found.height) == (20, 210)
    assert found.events["x"].tolist() == list(range(20))
    assert found.events["y"].tolist() == list(range(50, 70))
    assert found.frames[0].image.shape == (210, 20)
    assert found.frames[0].image.flags.c_contiguous


@pytest.mark.parametrize(
    ("window", "words"),
    [
        (Window(Direction.UP, 0, 301_000), r"to_s is 0.301 and the last event is at 0.299000 s"),
        (Window(Direction.UP, 400_000), r"from_s is 0.4 and the last event"),
        (Window(Direction.UP, crop=(0, 0, 347, 10)), r"crop is \[0, 0, 347, 10\] and the sensor"),
    ],
)
def test_a_window_beyond_the_recording_is_refused(
    tmp_path: Path, window: Window, words: str
) -> None:
    with pytest.raises(ManifestError, match=f"made: {words}"):
        read(tmp_path, window, file="a.npz", frames=0)


def test_a_crop_is_checked_before_the_events_are_read(tmp_path: Path) -> None:
    write_recording(tmp_path / "a.npz", ramp())
    windows = (Window(Direction.UP, crop=(0, 0, 9, 9)), Window(Direction.UP, crop=(0, 0, 9, 261)))
    with pytest.raises(ManifestError, match=r"made: crop is \[0, 0, 9, 261\] and the sensor"):
        check_recording(Recording("made", "a.npz", "", "", "", windows), tmp_path / "a.npz")


def test_a_window_may_end_up_to_1_ms_after_the_last_event(tmp_path: Path) -> None:
    (found,) = read(tmp_path, Window(Direction.UP, 0, 300_000), file="a.npz", frames=0)
    assert found.duration_us == 300_000


@pytest.mark.parametrize(("frames", "budget_gb"), [(0, "1.19e-5"), (6, "0.0128")])
def test_more_than_the_memory_budget_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, frames: int, budget_gb: str
) -> None:
    monkeypatch.setattr("flybench.memory._counted", {})
    monkeypatch.setenv(VARIABLE, budget_gb)
    windows = [Window(Direction.UP)] * (4 if frames else 1)
    with pytest.raises(MemoryBudgetError, match="the windows of made needs"):
        read(tmp_path, *windows, file="a.aedat4" if frames else "a.npz", frames=frames)


def test_the_windows_count_as_long_as_they_live(tmp_path: Path) -> None:
    before = free_bytes()
    stimuli = read(tmp_path, Window(Direction.UP), file="a.npz", frames=0)
    assert before - free_bytes() == 300 * 40
    del stimuli
    assert free_bytes() == before


def test_what_is_uncertain_about_a_file_is_printed_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,x,y,p\n" + "".join(f"{k // 10},{k % 99},9,1\n" for k in range(1000)))
    made = Recording("made", "a.csv", "", "", "", (Window(Direction.UP),), size=(WIDTH, HEIGHT))
    with open_events(path, size=made.size) as file:
        (warning,) = file.warnings
    check_recording(made, path)
    assert capsys.readouterr().err == f"flybench: warning: {warning}\n"
    read_stimuli(made, path)
    assert capsys.readouterr().err == ""


def test_a_recording_without_events_is_refused(tmp_path: Path) -> None:
    write_recording(tmp_path / "a.npz", ramp()[:0])
    what = Recording("made", "a.npz", "", "", "", (Window(Direction.UP),))
    with pytest.raises(ManifestError, match=r"a\.npz contains no events"):
        read_stimuli(what, tmp_path / "a.npz")
