"""Times of video frames from time stamps of any kind."""

from pathlib import Path

import numpy as np
import pytest

from scenarios.emulate.video_times import cut_warnings, video_times
from scenarios.errors import ScenarioError

CLIP = Path("clip.mkv")


def stamps(*frames: float, hz: float = 60.0) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array(frames, np.float64) * (1e3 / hz)


def test_stamps_that_only_round_a_constant_rate_are_evenly_spaced() -> None:
    times = video_times(CLIP, np.rint(stamps(*range(50))), 60.0)
    assert times.t_us.tolist() == [round(k * 1e6 / 60) for k in range(50)]
    assert times.rate() == "60 Hz"


def test_whole_milliseconds_that_vary_are_kept() -> None:
    times = video_times(CLIP, np.array([0.0, 10.0, 30.0, 40.0]), 75.0)
    assert times.t_us.tolist() == [0, 10_000, 30_000, 40_000]
    assert times.rate() == "50 to 100 Hz, varies"


def test_b_frames_in_avi_have_no_stamps_at_the_end() -> None:
    """OpenCV reports 0 for them, and a first stamp of two frames."""
    found = video_times(CLIP, stamps(*range(2, 60), 0, 0), 60.0)
    assert found.t_us.tolist() == [round(k * 1e6 / 60) for k in range(60)]
    assert found.warnings == ()


@pytest.mark.parametrize(
    ("given", "frame"),
    [(np.zeros(9), 1), (stamps(0, 1, 2, 5, 9, 0, 0), 5), (stamps(0, 1, 2, 2, 4), 3)],
)
def test_without_usable_stamps_the_stated_rate_counts_with_a_warning(
    given: np.ndarray[tuple[int], np.dtype[np.float64]], frame: int
) -> None:
    times = video_times(CLIP, given, 25.0)
    assert times.t_us.tolist() == [40_000 * k for k in range(given.size)]
    assert f"no usable time stamps: that of frame {frame} " in times.warnings[0]
    with pytest.raises(ScenarioError, match="states neither its frames per second nor"):
        video_times(CLIP, given, None)


@pytest.mark.parametrize(
    ("given", "stated_s", "start_s", "is_cut"),
    [
        (stamps(*range(60)), 1.0, 0.0, False),
        (stamps(*range(59)), 1.0, 0.0, False),  # 17 ms may be sound
        (stamps(*range(30)), 1.0, 0.0, True),
        (stamps(*range(30), *range(30, 150, 4)), 2.45, 0.0, False),
        (stamps(*range(30)), 5.5, 5.0, False),  # begins at 5 s
        (stamps(*range(600)), 10.2, 0.0, False),  # longer sound
        (stamps(*range(600)), 11.0, 0.0, True),
        (np.zeros(30), 0.5, 0.0, False),
        (np.zeros(30), 1.0, 0.0, True),
    ],
)
def test_a_video_is_cut_if_its_frames_end_before_the_stated_length(
    given: np.ndarray[tuple[int], np.dtype[np.float64]],
    stated_s: float,
    start_s: float,
    is_cut: bool,
) -> None:
    count = round(60 * stated_s)
    found = cut_warnings(CLIP, given, fps=60.0, count=count, start_s=start_s)
    assert bool(found) == is_cut
    assert all("It may be truncated." in warning for warning in found)
