"""Ground truth for events: which object each event came from, and the true flow at its pixel.

The geometry is computed once for every short span of time. An event belongs to an object that
covers the middle of the event's pixel or lies within one pixel of it, because the lens blurs light
over that distance. It may do so at the event's time or shortly before, because the sensor responds
with a delay.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.events import Cause, Events, check_events
from flybench.kernels import compiled
from sim.crossing import Crossing
from sim.errors import SimError
from sim.raster.aperture import BLUR_REACH_PX
from sim.raster.flow import flow_px_s
from sim.truth.dense_truth import BACKGROUND, DenseTruth

NOISE = -2
"""Source of an event that no change of luminance caused."""
TOLERANCE_PX = 0.5
"""How far the fastest object may move from the position for which its geometry is computed [px].
Half a pixel is less than the radius of the lens's blur (assumed)."""
MAX_SPAN_US = 1_000
"""Longest span of time that shares one computed geometry [µs] (assumed)."""
MIN_SPAN_US = 20
"""Shortest such span [µs] (assumed)."""
MAX_DELAY_US = 1_000
"""How long after an object has left a pixel the sensor may still respond to it [µs] (assumed)."""
NEVER_US = -(1 << 62)
"""A time before all others [µs]."""

F32 = npt.NDArray[np.float32]
I8 = npt.NDArray[np.int8]
I16 = npt.NDArray[np.int16]
I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class EventTruth:
    """Source and true flow of every event.

    Attributes:
        source: (n,) int8 number of the object in `Scene.objects`. `BACKGROUND`, -1: the luminance
            of the background changed, because the camera shook, a lamp flickered, or a headlight
            beam or a shadow passed. `NOISE`, -2: no luminance changed.
        flow_px_s: (n, 2) float32, x and y: image velocity of that object at the event's pixel, or
            of the background that the middle of the pixel shows; NaN for noise.
    """

    source: I8
    flow_px_s: F32


def event_truth(
    events: Events,
    causes: npt.ArrayLike,
    crossing: Crossing,
    *,
    signal: Collection[int] | int = Cause.SIGNAL,
    max_delay_us: int = MAX_DELAY_US,
    tolerance_px: float = TOLERANCE_PX,
) -> EventTruth:
    """Find the source and the true flow of every event.

    The geometry is that of the middle of a span of at most 1 ms, in which the fastest object moves
    at most `tolerance_px` from its position at the middle. This displacement is the only error of
    the flow.

    Args:
        events: (n,) events of `EVENT_DTYPE`, sorted by t; t is the time since the start of the
            sequence [µs].
        causes: (n,) cause of each event.
        crossing: the crossing that the sensor saw.
        signal: cause, or causes, of the events that a change of luminance made.
        max_delay_us: how long after an object has left a pixel an event there may still belong to
            it [µs].
        tolerance_px: how far the fastest object may move from the position for which its geometry
            is computed [px].

    Raises:
        EventError: the events have another dtype, are not sorted, or lie outside the sensor.
        SimError: there is not one cause per event, `max_delay_us` is negative, or `tolerance_px`
            is not positive.
    """
    causes = np.asarray(causes)
    _check(events, causes, crossing, max_delay_us, tolerance_px)
    signal_causes = sorted(signal) if isinstance(signal, Collection) else [signal]
    chosen = np.flatnonzero(np.isin(causes, signal_causes))
    source = np.full(len(events), NOISE, np.int8)
    flow = np.full((len(events), 2), np.nan, np.float32)
    times_us, columns, rows = (np.ascontiguousarray(events[name][chosen]) for name in "txy")
    geometry = DenseTruth(crossing.scene, crossing.intrinsics)
    last = _nothing_seen(crossing.intrinsics.height, crossing.intrinsics.width)
    for start_us, end_us in _spans(crossing, times_us, max_delay_us, tolerance_px):
        middle_us = (start_us + end_us) // 2
        t_s = crossing.seconds(middle_us)
        visible, twists = geometry.visible(t_s), geometry.twists(t_s)
        flow_now = flow_px_s(visible, twists, crossing.intrinsics)
        _update(last, middle_us, geometry.object_of_body, visible.body, visible.nearness, flow_now)
        within = slice(*np.searchsorted(times_us, [start_us, end_us]))
        source[chosen[within]], flow[chosen[within]] = _look_up(
            last, columns[within], rows[within], flow_now, middle_us - max_delay_us
        )
    return EventTruth(source, flow)


def _spans(
    crossing: Crossing, times_us: I64, max_delay_us: int, tolerance_px: float
) -> Iterator[tuple[int, int]]:
    """Half-open spans that cover every event's time and the `max_delay_us` before it [µs]."""
    if not times_us.size:
        return
    start_us, focal_px = max(int(times_us[0]) - max_delay_us, 0), crossing.intrinsics.focal_px
    while start_us <= times_us[-1]:
        next_event_us = int(times_us[np.searchsorted(times_us, start_us)])
        start_us = max(start_us, next_event_us - max_delay_us)
        fastest_px_s = crossing.scene.fastest_px_s(crossing.seconds(start_us), focal_px)
        length_us = 2e6 * tolerance_px / max(fastest_px_s, 1e-9)
        end_us = start_us + int(np.clip(length_us, MIN_SPAN_US, MAX_SPAN_US))
        yield start_us, end_us
        start_us = end_us


class _LastObjects(NamedTuple):
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


def _nothing_seen(height: int, width: int) -> _LastObjects:
    return _LastObjects(
        np.full((height, width), NEVER_US, np.int64),
        np.full((height, width), BACKGROUND, np.int8),
        np.zeros((height, width), np.float32),
        np.zeros((height, width, 2), np.float32),
    )


@compiled
def _update(
    last: _LastObjects, t_us: int, object_of_body: I8, body: I32, nearness: F32, flow: F32
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
def _look_up(
    last: _LastObjects, columns: I16, rows: I16, flow: F32, since_us: int
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


def _check(
    events: Events,
    causes: npt.NDArray[np.generic],
    crossing: Crossing,
    max_delay_us: int,
    tolerance_px: float,
) -> None:
    check_events(events, width=crossing.intrinsics.width, height=crossing.intrinsics.height)
    if causes.shape != (len(events),):
        raise SimError(
            f"causes has shape {causes.shape} for {len(events)} events. Allowed is one cause per "
            "event. Pass both arrays as the sensor returned them."
        )
    if not max_delay_us >= 0:
        raise SimError(
            f"max_delay_us is {max_delay_us!r}. Allowed is 0 µs or more. Leave it out for the "
            f"default of {MAX_DELAY_US} µs."
        )
    if not tolerance_px > 0:
        raise SimError(
            f"tolerance_px is {tolerance_px!r}. Allowed is more than 0 px. Leave it out for the "
            f"default of {TOLERANCE_PX} px."
        )
