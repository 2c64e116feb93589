"""Checks of recordings, hot pixels, and the order of events by pixel."""

from typing import Any

import numpy as np
import pytest

from emulator import FitError
from emulator.characterisation.recordings import check_recording, healthy_events, hot_pixels
from flybench.events import EVENT_DTYPE, empty_events


def test_hot_pixels_are_found_by_their_rate() -> None:
    rng = np.random.default_rng(1)
    number = rng.poisson(30, (40, 40))
    number[3, 4] = number[20, 7] = 900
    found = np.argwhere(hot_pixels(number))
    assert found.tolist() == [[3, 4], [20, 7]]
    assert not hot_pixels(rng.poisson(0.01, (40, 40))).any()


def test_healthy_events_are_sorted_by_pixel_and_time() -> None:
    hot = [(t, 0, 0, 1) for t in range(100)]
    events = np.array([*hot, (101, 2, 1, 1), (102, 1, 0, 1), (103, 2, 1, 0)], EVENT_DTYPE)
    found = healthy_events(events, (2, 3))
    assert found.pixel.tolist() == [1, 5, 5]
    assert found.events["t"].tolist() == [102, 101, 103]
    assert np.argwhere(~found.healthy).tolist() == [[0, 0]]


def test_numpy_sizes_become_python_integers() -> None:
    size: Any = {"width": np.int16(4), "height": np.int64(3)}
    width, height = check_recording(empty_events(), **size)
    assert (type(width), type(height), width, height) == (int, int, 4, 3)


@pytest.mark.parametrize("size", [{"width": 0}, {"width": 8.5}, {"height": True}, {"height": 4e4}])
def test_a_bad_size_is_refused(size: dict[str, Any]) -> None:
    (name,) = size
    with pytest.raises(
        FitError, match=f"{name} is .* Allowed is a whole number from 1 to 32767 px"
    ):
        check_recording(empty_events(), **{"width": 4, "height": 4, **size})
