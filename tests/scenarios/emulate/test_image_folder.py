"""Folders of images and the times that come with them."""

import os
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pytest

from flybench import files
from scenarios.emulate.frame_times import TimeOptions
from scenarios.emulate.pictures import open_pictures
from scenarios.errors import ScenarioError


def images(folder: Path, names: Sequence[str]) -> Path:
    """Write one image a name, brighter than the one before, and return the folder."""
    folder.mkdir(parents=True)
    for k, name in enumerate(names):
        cv2.imwrite(str(folder / name), np.full((4, 4), 10 * k, np.uint8))
    return folder


def levels(folder: Path, options: TimeOptions | None = None) -> list[int]:
    """Return the order in which images are read."""
    return [int(image[0, 0]) // 10 for image in open_pictures(folder, options or TimeOptions())]


def test_decimals_are_sorted_by_value_and_are_times(tmp_path: Path) -> None:
    folder = images(tmp_path / "a", [f"{round(k * 0.001, 3)}.png" for k in range(13)])
    assert levels(folder) == list(range(13))
    times = open_pictures(folder).times
    assert times.t_us.tolist() == [1000 * k for k in range(13)]
    assert "in s (fractions that give 1000 Hz; --time-unit sets another)" in times.source


@pytest.mark.parametrize(
    ("names", "expected_us"),
    [
        ([f"frame_{k / 30:.6f}.png" for k in range(5)], [33_333 * k for k in range(5)]),
        (["1e-05.png", "0.00102.png", "0.002.png"], [0, 1010, 1990]),
        ([f"{1000 * k}.png" for k in range(9, 14)], [1000 * k for k in range(5)]),  # 9000, 10000
        ([f"img_{1403636579763555584 + 50_000_000 * k}.png" for k in range(3)], [0, 50_000, 1e5]),
        ([f"1305031102.{k:06d}.png" for k in (175304, 211214, 243211)], [0, 35_910, 67_907]),
    ],
)
def test_names_that_are_times_are_read_in_their_unit(
    tmp_path: Path, names: list[str], expected_us: list[int]
) -> None:
    folder = images(tmp_path / "a", names)
    assert levels(folder) == list(range(len(names)))
    assert open_pictures(folder).times.t_us == pytest.approx(expected_us, abs=3)


@pytest.mark.parametrize(
    "names",
    [
        [f"frame_{k}.png" for k in range(8, 12)],
        ["0001.png", "0002.png", "0004.png", "0007.png"],  # frames are missing
        [f"shot1.{k:04d}.png" for k in range(4)],
        [f"img_1.{k}.png" for k in (1, 9, 10)],  # 1.1 and 1.10 are one value
        ["a.png", "b.png", "c.png"],
    ],
)
def test_frame_numbers_are_no_times(tmp_path: Path, names: list[str]) -> None:
    folder = images(tmp_path / "a", names)
    with pytest.raises(ScenarioError, match="does not state its frames per second"):
        open_pictures(folder)
    assert levels(folder, TimeOptions(fps=100.0)) == list(range(len(names)))


def test_a_unit_may_be_the_step_of_frame_numbers(tmp_path: Path) -> None:
    folder = images(tmp_path / "a", ["000.png", "001.png", "004.png"])
    times = open_pictures(folder, TimeOptions(unit="1/30s")).times
    assert times.t_us.tolist() == [0, 33_333, 133_333]
    (folder / "timestamps.txt").write_text("0\n3\n4\n")
    times = open_pictures(folder, TimeOptions(unit="33.3ms")).times
    assert times.t_us.tolist() == [0, 99_900, 133_200]


def test_a_stated_unit_makes_numbers_times(tmp_path: Path) -> None:
    folder = images(tmp_path / "a", [f"{k}.png" for k in (0, 33, 67, 100)])
    times = open_pictures(folder, TimeOptions(unit="ms")).times
    assert times.t_us.tolist() == [0, 33_000, 67_000, 100_000]
    assert times.source == "names of the images, in ms (--time-unit)"


@pytest.mark.parametrize(
    ("place", "name", "text"),
    [
        (".", "timestamps.txt", "0.0\n0.02\n0.03\n"),
        ("..", "times.txt", "0.000000e+00\n2.000000e-02\n3.000000e-02\n"),
        ("../..", "timestamps.txt", "49599300523\n49599320523\n49599330523\n"),
        ("..", "images.txt", "0.5 images/b.png\n0.48 images/a.png\n0.51 images/c.png\n"),
        ("..", "data.csv", "#timestamp [ns],filename\n0,a.png\n20000000,b.png\n30000000,c.png\n"),
        ("..", "rgb.txt", "# color\n# timestamp filename\n5.00 a.png\n5.02 b.png\n5.03 c.png\n"),
        (
            "..",
            "timestamps.txt",
            "2011-09-26 13:02:25.99\n2011-09-26 13:02:26.01\n2011-09-26 13:02:26.02\n",
        ),
    ],
)
def test_text_files_near_the_images_give_their_times(
    tmp_path: Path, place: str, name: str, text: str
) -> None:
    folder = images(tmp_path / "seq" / "images" / "left", ["a.png", "b.png", "c.png"])
    (folder / place / name).write_text(text)
    times = open_pictures(folder).times
    assert times.t_us.tolist() == [0, 20_000, 30_000]
    assert times.source.startswith(f"{name}, in ")
    assert times.rate() == "50 to 100 Hz, varies"


def test_images_are_read_in_the_order_of_their_times(tmp_path: Path) -> None:
    folder = images(tmp_path / "a", ["a.png", "b.png", "c.png"])
    (folder / "images.txt").write_text("0.3 a.png\n0.1 b.png\n0.2 c.png\n")
    assert levels(folder) == [1, 2, 0]


def test_a_file_of_another_sequence_is_not_used_and_this_is_said(tmp_path: Path) -> None:
    folder = images(tmp_path / "a" / "b", ["0.0.png", "0.1.png"])
    (tmp_path / "a" / "times.txt").write_text("0.0\n0.1\n0.2\n")
    times = open_pictures(folder).times
    assert times.source.startswith("names of the images")
    assert "times.txt has 3 times for 2 images" in times.warnings[0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0.0\n0.1\n", "has 2 times for 3 images"),
        ("0.0 a.png\n0.1 b.png\n", r"has no time for c\.png"),
        ("0.0\n0.2\n0.1\n", r"c\.png is -0\.1 s after b\.png .*Allowed is 1e-05 to 1074 s"),
        ("0.0\n0.1\n9e4\n", r"c\.png is 89999\.9 s after b\.png"),
        ("0\n1\n2\n", "contains frame numbers, not times"),
        ("", "has no times, or lines of different kinds"),
        ("0.0\n0.1 b.png\n0.2\n", "lines of different kinds"),
        ("0.0 1.0\n0.1 1.1\n0.2 1.2\n", "has 2 numbers a line"),
        ("1 0.1 0.2 0.3 a.png\n2 0.1 0.2 0.3 b.png\n3 0.1 0 0 c.png\n", "has 4 numbers a line"),
        ("0.0 a.png\n0.1 b.png\n0.2 c.png\n0.3 a.png\n", r"names a\.png twice"),
        ("0.0 x/a.png\n0.1 y/a.png\n0.2 b.png\n0.3 c.png\n", r"names a\.png twice"),
        ("2023-12-31 10:00:00\n2023-13-01 10:00:00\n", r"has the line 2: '2023-13-01 10:00:00'"),
        ("2023-12-31 10:60:00\n", r"has the line 1: .* a time of day that exist"),
        ("one two three\nfour\n", "has the line 2|lines of different kinds|has 0 numbers"),
    ],
)
def test_invalid_files_give_an_error(tmp_path: Path, text: str, words: str) -> None:
    folder = images(tmp_path / "a", ["a.png", "b.png", "c.png"])
    (folder / "timestamps.txt").write_text(text)
    with pytest.raises(ScenarioError, match=words):
        open_pictures(folder)


def test_a_file_for_several_folders_gives_each_its_own_times(tmp_path: Path) -> None:
    left, right = (images(tmp_path / side, ["a.png", "b.png"]) for side in ("left", "right"))
    lines = ["0.0 left/a.png", "0.5 right/a.png", "0.2 left/b.png", "0.6 right/b.png"]
    (tmp_path / "images.txt").write_text("\n".join(lines))
    assert open_pictures(left).times.t_us.tolist() == [0, 200_000]
    assert open_pictures(right).times.t_us.tolist() == [0, 100_000]
    (tmp_path / "images.txt").write_text("\n".join(lines[1::2]))
    with pytest.raises(ScenarioError, match=r"has no time for a\.png"):
        open_pictures(left, TimeOptions(file=tmp_path / "images.txt"))


def test_a_time_file_cannot_block_and_may_begin_with_a_mark(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "_WAIT_S", 0.05)
    folder = images(tmp_path / "a", ["a.png", "b.png"])
    os.mkfifo(tmp_path / "fifo")
    with pytest.raises(ScenarioError, match="it sends no data for"):
        open_pictures(folder, TimeOptions(file=tmp_path / "fifo"))
    (tmp_path / "marked.txt").write_text("0.0\n0.2\n", encoding="utf-8-sig")
    times = open_pictures(folder, TimeOptions(file=tmp_path / "marked.txt")).times
    assert times.t_us.tolist() == [0, 200_000]


def test_fps_overrides_a_file_and_a_chosen_file_is_read_first(tmp_path: Path) -> None:
    folder = images(tmp_path / "a", ["a.png", "b.png"])
    (folder / "timestamps.txt").write_text("damaged")
    assert open_pictures(folder, TimeOptions(fps=100.0)).times.t_us.tolist() == [0, 10_000]
    (tmp_path / "mine.txt").write_text("0 0.0\n1 0.2\n")
    times = open_pictures(folder, TimeOptions(file=tmp_path / "mine.txt")).times
    assert times.t_us.tolist() == [0, 200_000]
    with pytest.raises(ScenarioError, match=r"nowhere\.txt cannot be read"):
        open_pictures(folder, TimeOptions(file=tmp_path / "nowhere.txt"))
    with pytest.raises(ScenarioError, match="--times and --time-unit have no effect"):
        open_pictures(folder, TimeOptions(fps=100.0, file=tmp_path / "mine.txt"))
