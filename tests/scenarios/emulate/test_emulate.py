"""`flybench emulate`: events, warnings and errors."""

import os
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from PIL import Image

from emulator import EventSensor, preset
from flybench.events import Events
from formats import open_events, read_events
from scenarios.commands.emulate import Emulate
from scenarios.options.sensor import SensorOptions
from scenarios.output.terminal import execute
from tests.scenarios.emulate.moving_pictures import bar, wall, wall_sequence
from tests.scenarios.emulate.written_videos import fast_then_slow, write_video


@pytest.fixture(scope="module")
def array(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("pictures") / "wall.npy"
    np.save(path, wall_sequence(60, 0.5))
    return path


def emulate(source: Path, out: Path, **options: Any) -> Events:
    command = Emulate(source, out, fps=1000.0, sensor=SensorOptions("ideal"), transfer="linear")
    assert execute(replace(command, **options)) == 0
    return read_events(out)


def test_a_wrong_unit_is_refused_even_if_it_is_not_used(
    array: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert execute(Emulate(array, tmp_path / "a.npz", fps=1000.0, time_unit="min")) == 2
    assert "Allowed is one of s, ms, us, ns" in capsys.readouterr().err


def test_events_are_those_of_the_sensor(array: Path, tmp_path: Path) -> None:
    options = SensorOptions("v2e_noisy")
    found = emulate(array, tmp_path / "a.npz", white_cd_m2=300.0, sensor=options, seed=3)
    sensor = EventSensor(preset("v2e_noisy"), seed=3)
    expected = []
    for k, image in enumerate(np.load(array)):
        luminance = cv2.resize(image.astype(np.float32) * (300 / 255), (346, 260))
        expected.append(sensor.step(1000 * k, luminance).events)
    true = np.concatenate(expected)
    assert found.size == pytest.approx(true.size, rel=0.01)
    assert found.size > 10_000
    assert np.mean(found["p"]) == pytest.approx(np.mean(true["p"]), abs=0.01)
    assert found["t"].max() <= 59_000


def test_a_video_states_its_rate_and_aedat4_contains_frames(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    video, out = tmp_path / "wall.avi", tmp_path / "a.aedat4"
    writer = cv2.VideoWriter(str(video), cv2.VideoWriter.fourcc(*"MJPG"), 100.0, (172, 130))
    for image in wall_sequence(30, 0.3, columns=172):
        writer.write(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
    writer.release()
    assert execute(Emulate(video, out)) == 0
    captured = capsys.readouterr()
    assert "30 at 100 Hz" in captured.out
    assert "warning" not in captured.err
    with open_events(out) as file:
        frames = [frame for chunk in file for frame in chunk.frames]
        assert file.statistics.events > 1000
        assert len(frames) > 3
    assert frames[0].image.shape == (260, 346)


def test_a_playlist_reads_no_other_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other, playlist = tmp_path / "other.avi", tmp_path / "list.avi"
    writer = cv2.VideoWriter(str(other), cv2.VideoWriter.fourcc(*"MJPG"), 100.0, (64, 48))
    for level in range(5):
        writer.write(np.full((48, 64, 3), level, np.uint8))
    writer.release()
    playlist.write_text("ffconcat version 1.0\nfile other.avi\n")
    assert execute(Emulate(playlist, tmp_path / "a.h5")) == 2
    assert "list.avi is not a video that OpenCV can open" in capsys.readouterr().err


def test_a_fifo_among_images_does_not_block(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "frame_1.png")
    assert execute(Emulate(tmp_path, tmp_path / "a.h5", fps=10)) == 2


def test_images_are_read_in_the_order_of_their_numbers(tmp_path: Path, array: Path) -> None:
    folder = tmp_path / "images"
    folder.mkdir()
    for k, image in enumerate(np.load(array)[:12]):
        deep = image.astype(np.uint16) * 257
        cv2.imwrite(str(folder / f"frame_{k}.png"), deep if k % 2 else image)
    (folder / "notes.txt").write_text("not a picture")
    found = emulate(folder, tmp_path / "a.txt")
    np.save(tmp_path / "short.npy", np.load(array)[:12])
    assert np.array_equal(found, emulate(tmp_path / "short.npy", tmp_path / "b.txt"))
    assert found.size > 100


def test_large_motion_gives_a_warning_and_interpolation_is_more_accurate(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A wall moves at 4000 px/s on the sensor; frames at 16 000 Hz and at 1000 Hz."""
    fine, coarse = tmp_path / "fine.npy", tmp_path / "coarse.npy"
    np.save(fine, wall_sequence(161, 0.125))
    np.save(coarse, wall_sequence(11, 2.0))
    true = emulate(fine, tmp_path / "fine.npz", fps=16_000.0)
    assert "warning" not in capsys.readouterr().err
    plain = emulate(coarse, tmp_path / "plain.npz")
    err = capsys.readouterr().err
    assert re.search(r"move by up to [34]\.\d px .* in 10 of 10 steps.* or give --interpolate", err)
    filled = emulate(coarse, tmp_path / "filled.npz", interpolate=True)
    assert "warning" not in capsys.readouterr().err
    assert abs(filled.size - true.size) < 0.05 * true.size
    assert _mean_error(filled, true) < 0.5 * _mean_error(plain, true)


def test_a_bar_needs_few_interpolated_frames(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    luminance = [200 * bar(2.0 * k, rows=260, columns=346) for k in range(7)]
    np.save(tmp_path / "bar.npy", luminance)
    emulate(tmp_path / "bar.npy", tmp_path / "a.npz", interpolate=True)
    captured = capsys.readouterr()
    assert "warning" not in captured.err
    interpolated = re.search(r"interpolated *│ *(\d+),", captured.out)
    assert interpolated is not None
    assert 6 <= int(interpolated[1]) <= 6 * 4


def _mean_error(found: Events, true: Events) -> float:
    """Return the mean error of the time of a pixel's first event [µs]."""
    first = []
    for events in (found, true):
        times = np.full((260, 346), np.nan)
        times[events["y"][::-1], events["x"][::-1]] = events["t"][::-1]
        first.append(times[40:-40, 60:-60])
    return float(np.nanmean(np.abs(first[0] - first[1])))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"input": Path("nowhere.mp4")}, "nowhere.mp4 does not exist. Allowed is a video"),
        ({"input": Path("invalid.mp4")}, "invalid.mp4 is not a video that OpenCV can open"),
        ({"input": Path("empty.mp4")}, "empty.mp4 is empty"),
        ({"input": Path("still.png")}, "is a single image. .* Give the folder"),
        (
            {"input": Path("none")},
            "The folder none contains no images. Allowed are the endings .bmp",
        ),
        ({"input": Path("sizes")}, "b.png has 9x9 px, and the first image 8x8"),
        ({"input": Path("bomb")}, "large.png has 6000x6000 px. Allowed are"),
        ({"input": Path("damaged")}, "a.png is not a readable image of 8 or 16 bits"),
        ({"input": Path("text.npy")}, "text.npy cannot be read as an array"),
        ({"input": Path("flat.npy")}, "contains float64 of shape"),
        ({"input": Path("one.npy")}, "one.npy contains 1 frames. Allowed are 2 or more"),
        (
            {"input": Path("hole.npy")},
            "frame 2 .* is nan cd/m² at row 5, column 7. Allowed",
        ),
        ({"input": Path("below.npy")}, "luminance of frame 0 .* is -1 cd/m²"),
        ({"fps": None}, "does not state its frames per second. Give them with --fps"),
        ({"fps": 0.0}, "The frame rate is 0 frames per second. Allowed is 0.1 to 100000"),
        ({"white_cd_m2": 0.0}, "white_cd_m2 is 0.0"),
        ({"out": Path("a.mp4")}, "ends in .mp4. Allowed is one of .aedat4"),
        ({"out": Path("no/a.h5")}, "--out no/a.h5 cannot be written"),
        ({"out": Path("none")}, "--out none is a folder"),
    ],
)
def test_invalid_input_gives_a_one_line_error(
    array: Path, changes: Any, words: str, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    _write_invalid_files(tmp_path)
    before = sorted(path.name for path in tmp_path.iterdir())
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        assert execute(replace(Emulate(array, Path("a.h5"), fps=1000.0), **changes)) == 2
    err = capfd.readouterr().err
    (message,) = [line for line in err.splitlines() if "flybench: " in line]
    assert "Warning" not in err
    assert re.search(words, message)
    assert sorted(path.name for path in tmp_path.iterdir()) == before


def _write_invalid_files(folder: Path) -> None:
    (folder / "invalid.mp4").write_bytes(b"\0\0\0\x18ftypmp42" + bytes(1000))
    (folder / "empty.mp4").touch()
    (folder / "text.npy").write_text("no array")
    np.save(folder / "flat.npy", np.zeros((5, 5)))
    np.save(folder / "one.npy", np.zeros((1, 5, 5), np.uint8))
    luminance = np.full((3, 260, 346), 10.0)
    np.save(folder / "below.npy", -0.1 * luminance)
    luminance[2, 5, 7] = np.nan
    np.save(folder / "hole.npy", luminance)
    for name in ("none", "sizes", "damaged", "bomb"):
        (folder / name).mkdir()
    cv2.imwrite(str(folder / "still.png"), np.zeros((8, 8), np.uint8))
    for name, side in (("a.png", 8), ("b.png", 9)):
        cv2.imwrite(str(folder / "sizes" / name), np.zeros((side, side), np.uint8))
    Image.new("1", (6000, 6000)).save(folder / "bomb" / "large.png")
    (folder / "damaged" / "a.png").write_bytes(b"\x89PNG\r\n\x1a\nnothing")
    for name in ("bomb", "damaged"):
        shutil.copy(folder / "still.png", folder / name / "next.png")


def test_an_array_of_luminance_is_accepted(tmp_path: Path) -> None:
    luminance = np.stack([200 * wall(0.5 * k, rows=260, columns=346) for k in range(20)])
    np.save(tmp_path / "luminance.npy", luminance)
    assert emulate(tmp_path / "luminance.npy", tmp_path / "a.npz").size > 1000


def test_a_file_of_the_user_is_replaced_only_with_overwrite(
    array: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine.csv"
    mine.write_text("mine")
    command = Emulate(array, mine, fps=1000.0)
    assert execute(command) == 2
    assert "exists already. Allowed is a new file." in capsys.readouterr().err
    assert mine.read_text() == "mine"
    assert execute(replace(command, overwrite=True)) == 0
    assert read_events(mine).size > 0


def test_motion_in_bright_luminance_is_noticed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A wall of up to 5000 cd/m² moves by 4 px per frame, far above a display's 200 cd/m²."""
    luminance = np.stack([5000 * wall(4.0 * k, rows=260, columns=346) for k in range(4)])
    np.save(tmp_path / "bright.npy", luminance)
    emulate(tmp_path / "bright.npy", tmp_path / "a.npz")
    captured = capsys.readouterr()
    assert re.search(r"move by up to [34]\.\d px .* in 3 of 3 steps", captured.err)
    assert re.search(r"up to 4\d\d\d cd/m², from the array", captured.out)
    emulate(tmp_path / "bright.npy", tmp_path / "b.npz", interpolate=True)
    captured = capsys.readouterr()
    interpolated = re.search(r"interpolated *│ *(\d+),", captured.out)
    assert interpolated is not None
    assert 3 * 6 <= int(interpolated[1]) <= 3 * 9
    assert "warning" not in captured.err


def test_a_flash_in_a_video_of_varying_rate_comes_at_its_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Frame 53 of 60, at 2.033 s, is the first bright one; index/fps would give 0.883 s."""
    levels = [40] * 53 + [200] * 7
    write_video(tmp_path / "flash.mkv", fast_then_slow(), per_s=60, levels=levels)
    events = tmp_path / "a.npz"
    assert execute(Emulate(tmp_path / "flash.mkv", events, sensor=SensorOptions("ideal"))) == 0
    t_us = read_events(events)["t"]
    assert t_us.min() >= 1_967_000
    assert t_us.max() <= 2_034_000
    captured = capsys.readouterr()
    assert "60 at 14.9 to 62.5 Hz, varies, 2.433 s" in captured.out
    assert "warning" not in captured.err


def test_no_input_is_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder, array = tmp_path / "im", tmp_path / "a.npy"
    folder.mkdir()
    for k, image in enumerate(wall_sequence(3, 0.5)):
        Image.fromarray(image).save(folder / f"{k}.png")
    np.save(array, wall_sequence(3, 0.5))
    times = folder / "timestamps.txt"
    times.write_text("0.0\n0.02\n0.03\n")
    (tmp_path / "link.txt").symlink_to(times)
    for command in (
        Emulate(folder, times),
        Emulate(folder, tmp_path / "link.txt"),
        Emulate(folder, folder / ".." / "im" / times.name, times=times),
        Emulate(array, array, fps=100.0),
    ):
        assert execute(replace(command, overwrite=True)) == 2
        assert "which is a file to read" in capsys.readouterr().err
    assert times.read_text() == "0.0\n0.02\n0.03\n"


def test_warnings_about_times_come_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "images"
    folder.mkdir()
    cv2.imwrite(str(folder / "0.0.png"), np.zeros((4, 4), np.uint8))
    (folder / "0.1.png").write_text("damaged")
    (tmp_path / "times.txt").write_text("0.0\n0.1\n0.2\n")
    assert execute(Emulate(folder, tmp_path / "a.npz")) == 2
    warning, *_, error = capsys.readouterr().err.splitlines()
    assert warning.startswith("flybench: warning: ")
    assert "times.txt is not used" in warning
    assert "0.1.png" in error
