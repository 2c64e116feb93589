"""Recordings as input: checks, hot pixels, and events in the order of their pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator.characterisation.bench import Counts, event_counts
from emulator.errors import FitError
from flybench.checks import Range
from flybench.events import Events, check_events

_SIDE = Range(1, 32767, "px", "Give the size of the sensor that made the recording.")
_HOT_DEVIATIONS = 8.0
"""Standard deviations above which a pixel is hot: chance takes one healthy pixel in 10¹⁵ there."""


@dataclass(frozen=True, eq=False)
class PixelEvents:
    """Events of the healthy pixels, sorted by pixel and then by time.

    Attributes:
        events: (n,) of `EVENT_DTYPE`.
        pixel: (n,) pixel of each event, as row × width + column.
        healthy: (height, width), False for the hot pixels that were left out.
    """

    events: Events
    pixel: npt.NDArray[np.int64]
    healthy: npt.NDArray[np.bool_]


def check_recording(events: Events, *, width: int, height: int) -> tuple[int, int]:
    """Check that events are a sorted stream from a sensor of this size.

    Returns:
        Width and height as Python integers [px].

    Raises:
        EventError: the events are not a sorted stream from such a sensor.
        FitError: the width or height is not a whole number from 1 to 32767.
    """
    width = _SIDE.check("width", width, FitError)
    height = _SIDE.check("height", height, FitError)
    check_events(events, width=width, height=height)
    return width, height


def hot_pixels(number: Counts) -> npt.NDArray[np.bool_]:
    """Find pixels that fire far more often than the others.

    Args:
        number: (height, width) events of each pixel.

    Returns:
        (height, width), True where a count is more than eight standard deviations above the median.
        The deviation is the larger of the Poisson deviation and the one estimated from the
        quartiles of the array.
    """
    low, median, high = np.percentile(number, [25, 50, 75])
    deviation = max(np.sqrt(median + 1.0), (high - low) / 1.35)
    return np.asarray(number > median + _HOT_DEVIATIONS * deviation, np.bool_)


def healthy_events(events: Events, shape: tuple[int, int]) -> PixelEvents:
    """Leave out hot pixels and sort the other events by pixel and time.

    Args:
        events: sorted by t.
        shape: rows and columns of the sensor.
    """
    healthy = ~hot_pixels(event_counts(events, shape))
    kept = events[healthy[events["y"], events["x"]]]
    ordered = kept[np.lexsort((kept["t"], kept["x"], kept["y"]))]
    return PixelEvents(ordered, ordered["y"].astype(np.int64) * shape[1] + ordered["x"], healthy)
