"""Frames of videos and their times."""

from pathlib import Path

import numpy as np
import pytest

from scenarios.emulate.frame_times import TimeOptions
from scenarios.emulate.pictures import open_pictures
from scenarios.errors import ScenarioError
from tests.scenarios.emulate.written_videos import fast_then_slow, write_video


@pytest.mark.parametrize(
    ("name", "tolerance_us", "rate"),
    [("a.mov", 0, "15 to 60 Hz, varies"), ("a.mkv", 500, "14.9 to 62.5 Hz, varies")],
)
def test_each_frame_has_the_time_of_its_own_stamp(
    tmp_path: Path, name: str, tolerance_us: int, rate: str
) -> None:
    write_video(tmp_path / name, fast_then_slow(), per_s=60)
    pictures = open_pictures(tmp_path / name)
    true_us = np.rint(np.array(fast_then_slow()) * 1e6 / 60)
    assert np.abs(pictures.times.t_us - true_us).max() <= tolerance_us
    assert pictures.times.rate() == rate
    assert pictures.times.source == "time stamps of the video"
    assert pictures.times.warnings == ()
    assert len(list(pictures)) == 60


@pytest.mark.parametrize("name", ["a.mkv", "a.mov", "a.avi"])
@pytest.mark.parametrize("per_s", [30, 60, 240])
def test_a_constant_rate_is_exact_though_the_file_rounds_times(
    tmp_path: Path, name: str, per_s: int
) -> None:
    write_video(tmp_path / name, range(40), per_s=per_s)
    times = open_pictures(tmp_path / name).times
    assert times.t_us.tolist() == [round(k * 1e6 / per_s) for k in range(40)]
    assert (times.rate(), times.warnings) == (f"{per_s} Hz", ())


def test_fps_and_a_text_file_replace_the_time_stamps(tmp_path: Path) -> None:
    video, text = tmp_path / "a.mkv", tmp_path / "times.txt"
    write_video(video, fast_then_slow(10), per_s=60)
    times = open_pictures(video, TimeOptions(fps=1000.0)).times
    assert times.t_us.tolist() == [1000 * k for k in range(10)]
    text.write_text("\n".join(f"{0.01 * k**2:.4f}" for k in range(10)))
    times = open_pictures(video, TimeOptions(file=text)).times
    assert times.t_us.tolist() == [10_000 * k**2 for k in range(10)]
    text.write_text("0.0\n0.1\n")
    with pytest.raises(ScenarioError, match=r"times\.txt has 2 times for 10 frames"):
        open_pictures(video, TimeOptions(file=text))


def test_a_unit_without_times_in_text_is_refused(tmp_path: Path) -> None:
    write_video(tmp_path / "a.mkv", range(3), per_s=60)
    with pytest.raises(ScenarioError, match="--time-unit has no effect on"):
        open_pictures(tmp_path / "a.mkv", TimeOptions(unit="us"))


def test_a_truncated_video_gives_a_warning(tmp_path: Path) -> None:
    write_video(tmp_path / "a.mkv", fast_then_slow(), per_s=60)
    whole = (tmp_path / "a.mkv").read_bytes()
    (tmp_path / "cut.mkv").write_bytes(whole[: len(whole) // 2])
    times = open_pictures(tmp_path / "cut.mkv").times
    assert times.t_us.size < 40
    assert any("It may be truncated" in warning for warning in times.warnings)
