"""Images of the events of a window."""

from base64 import b64decode

import cv2
import numpy as np
import pytest

from flybench.events import EVENT_DTYPE, empty_events
from flybench.memory import MemoryBudgetError
from scenarios.output.colours import ON
from scenarios.validate.event_image import IMAGES, event_images
from scenarios.validate.stimulus import Stimulus


def test_an_image_shows_the_last_20_ms_in_the_colours_of_the_polarity() -> None:
    events = np.zeros(3, EVENT_DTYPE)
    events["t"] = 5_000, 25_000, 99_000  # the second is between two images
    events["x"], events["y"], events["p"] = (1, 2, 3), (0, 1, 2), (True, False, True)
    images = event_images(Stimulus(events, (), 5, 4, 100_000))
    assert [end_us for end_us, _ in images] == [20_000, 46_667, 73_333, 100_000]
    pictures = []
    for _, address in images:
        assert address.startswith("data:image/png;base64,")
        png = np.frombuffer(b64decode(address.split(",")[1]), np.uint8)
        pictures.append(cv2.imdecode(png, cv2.IMREAD_COLOR))
    first, second, third, last = pictures
    assert first is not None
    assert first.shape == (4, 5, 3)
    assert [int((p != 255).any(axis=2).sum()) for p in pictures if p is not None] == [1, 0, 0, 1]
    assert tuple(first[0, 1][::-1]) == ON
    assert last is not None
    assert tuple(last[2, 3][::-1]) == ON
    assert second is not None
    assert third is not None


def test_a_short_window_has_as_many_images() -> None:
    events = np.zeros(1, EVENT_DTYPE)
    assert len(event_images(Stimulus(events, (), 5, 4, 3000))) == IMAGES


def test_an_image_beyond_the_memory_budget_is_refused() -> None:
    with pytest.raises(MemoryBudgetError, match="An image of 32000×32000 px needs"):
        event_images(Stimulus(empty_events(), (), 32_000, 32_000, 3000))
