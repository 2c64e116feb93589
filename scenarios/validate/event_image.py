"""Images of the events of a window, so that a person can check the true direction by eye."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence

import cv2
import numpy as np

from flybench.events import Events
from flybench.memory import check_memory
from scenarios.detect.plot_data import SNAPSHOT_US
from scenarios.output.colours import OFF, ON
from scenarios.validate.stimulus import Stimulus

IMAGES = 4
"""Images of a window, at equal steps from its start to its end (assumed)."""

_BYTES_PER_PX = 19
"""Memory for a pixel: the image, and at most its PNG, which is copied twice as text."""


def event_images(stimulus: Stimulus) -> Sequence[tuple[int, str]]:
    """Return images of `SNAPSHOT_US` of events each.

    Returns:
        For each image the time of its last event, after the start of the window [µs], and its
        address as a PNG in a "data:" URL.

    Raises:
        MemoryBudgetError: an image needs more memory than the budget allows.
    """
    width, height = stimulus.width, stimulus.height
    check_memory(f"An image of {width}×{height} px", _BYTES_PER_PX * width * height)
    first_us = min(SNAPSHOT_US, stimulus.duration_us)
    ends_us = np.linspace(first_us, stimulus.duration_us, IMAGES).round().astype(int).tolist()
    return [(end_us, _png(stimulus, _last_events(stimulus.events, end_us))) for end_us in ends_us]


def _last_events(events: Events, end_us: int) -> Events:
    first, end = np.searchsorted(events["t"], [end_us - SNAPSHOT_US, end_us])
    return events[first:end]


def _png(stimulus: Stimulus, events: Events) -> str:
    """Return a PNG that is transparent without events, for light and dark pages."""
    image = np.full((stimulus.height, stimulus.width, 4), (255, 255, 255, 0), np.uint8)
    for polarity, colour in ((False, OFF), (True, ON)):
        of_polarity = events[events["p"] == polarity]
        image[of_polarity["y"], of_polarity["x"]] = (
            *colour[::-1],
            255,
        )  # OpenCV takes blue, green, red
    _, png = cv2.imencode(".png", image)
    return f"data:image/png;base64,{b64encode(png.tobytes()).decode()}"
