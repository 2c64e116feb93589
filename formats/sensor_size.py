"""The size of a sensor that a file does not state, from the extent of its events."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from formats.columns import MAX_SIDE_PX, EventColumns, ParsedItem, Size, valid_length
from formats.errors import FormatError

_SENSOR_SIZES: tuple[Size, ...] = (
    (128, 128),
    (240, 180),
    (304, 240),
    (320, 320),
    (346, 260),
    (640, 480),
    (1280, 720),
)
"""Width and height of common sensors [px]."""


def infer_size(
    path: Path, items: Iterator[ParsedItem], possible: tuple[Size, ...], working: Callable[[], None]
) -> Size:
    """Return the size of the sensor from the extent of the events [px].

    Args:
        path: path of the file, for messages.
        items: events and frames of the file.
        possible: sizes that the sensor may have; empty: any.
        working: function that is called for every block of events.

    Returns:
        The smallest possible size that contains the events; or, if any is possible, the smallest
        common sensor of which the events span at least 90 % each way, or else their extent.
    """
    width, height = _extent(path, items, working)
    if possible:
        fitting = (size for size in possible if width <= size[0] and height <= size[1])
        return next(fitting, (width, height))
    for columns, rows in _SENSOR_SIZES:
        if 0.9 * columns <= width <= columns and 0.9 * rows <= height <= rows:
            return columns, rows
    return width, height


def _extent(path: Path, items: Iterator[ParsedItem], working: Callable[[], None]) -> Size:
    """Return the number of columns and rows up to the last with an event [px]."""
    width = height = done = 0
    try:
        for item in items:
            working()
            if not isinstance(item, EventColumns) or not item.t.size:
                continue
            largest = (MAX_SIDE_PX, MAX_SIDE_PX)
            valid, error = valid_length(item, largest, path=path, done=done)
            if valid:
                width = max(width, int(item.x[:valid].max()) + 1)
                height = max(height, int(item.y[:valid].max()) + 1)
            done += valid
            if error is not None:
                raise error
    except FormatError:  # the second pass sends the events before the error, and raises it again
        if not done:
            raise
    if not done:
        raise FormatError(
            f"{path} contains no events, so the size of its sensor is unknown. Allowed is a "
            "recording with events, or a stated size. Give the size with --size."
        )
    return width, height
