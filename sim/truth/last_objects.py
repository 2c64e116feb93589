"""The object that each pixel showed last, and the objects that events came from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.raster.aperture import BLUR_REACH_PX
from sim.truth.dense_truth import BACKGROUND

F32 = npt.NDArray[np.float32]
I8 = npt.NDArray[np.int8]
I16 = npt.NDArray[np.int16]
I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]

NEVER_US = -(1 << 62)
"""A time before all others [µs]."""


class LastObjects(NamedTuple):
    """The object that each pixel showed last.

    Attributes:
        t_us: (height, width) int64 time at which the middle of the pixel showed it [µs].
        number: (height, width) int8 its number.
        nearness: (height, width) float32 its nearness at that time [1/m].
        flow_px_s: (height, width, 2) float32 its image velocity at that time.
    """

    t_us: I64
    number: I8
    nearness: F32
    flow_px_s: F32


def nothing_seen(height: int, width: int) -> LastObjects:
    """Return the state before the first time."""
    return LastObjects(
        np.full((height, width), NEVER_US, np.int64),
        np.full((height, width), BACKGROUND, np.int8),
        np.zeros((height, width), np.float32),
        np.zeros((height, width, 2), np.float32),
    )


@compiled
def update_last(
    last: LastObjects, t_us: int, object_of_body: I8, body: I32, nearness: F32, flow: F32
) -> None:
    """Write the objects visible at a time, later than all before, into `last`, in place."""
    for row in range(body.shape[0]):
        for column in range(body.shape[1]):
            shown = body[row, column]
            if shown <= 0 or object_of_body[shown] < 0:
                continue
            last.t_us[row, column] = t_us
            last.number[row, column] = object_of_body[shown]
            last.nearness[row, column] = nearness[row, column]
            last.flow_px_s[row, column, 0] = flow[row, column, 0]
            last.flow_px_s[row, column, 1] = flow[row, column, 1]


@compiled
def look_up_last(
    last: LastObjects, columns: I16, rows: I16, flow: F32, since_us: int
) -> tuple[I8, F32]:
    """Find the object that each event came from.

    It is the object seen last within reach of the pixel, at `since_us` or later. If several were
    seen at that time, it is the one at the pixel itself, else the nearest to the camera.

    Args:
        last: the object that each pixel showed last.
        columns: (n,) columns of the events.
        rows: (n,) rows of the events.
        flow: (height, width, 2) image velocity of what each pixel shows [px/s]; used where no
            object is found.
        since_us: objects last seen before this time do not count [µs].

    Returns:
        (n,) int8 sources and (n, 2) float32 flows [px/s]; see `EventTruth`.
    """
    height, width = last.t_us.shape
    source = np.full(len(columns), BACKGROUND, np.int8)
    found_flow = np.empty((len(columns), 2), np.float32)
    for k in range(len(columns)):
        column, row = columns[k], rows[k]
        found_flow[k] = flow[row, column]
        best_us, best_nearness = since_us, np.float32(-1.0)
        for y in range(max(row - BLUR_REACH_PX, 0), min(row + BLUR_REACH_PX + 1, height)):
            for x in range(max(column - BLUR_REACH_PX, 0), min(column + BLUR_REACH_PX + 1, width)):
                at_pixel = y == row and x == column
                nearness = np.float32(np.inf) if at_pixel else last.nearness[y, x]
                later = last.t_us[y, x] > best_us
                if later or (last.t_us[y, x] == best_us and nearness > best_nearness):
                    best_us, best_nearness = last.t_us[y, x], nearness
                    source[k] = last.number[y, x]
                    found_flow[k] = last.flow_px_s[y, x]
    return source, found_flow
