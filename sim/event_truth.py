"""Where events came from: for each, which object, and the true flow at its place and time.

Geometry is drawn anew for every short span of time. An event is its object's where the object is
at the pixel's middle or within a pixel of it, since a pixel sees that far through the lens, at the
event's time or shortly before, since a sensor answers late.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.crossing import Crossing
from sim.errors import SimError
from sim.raster.aperture import BLUR_REACH_PX
from sim.raster.flow import flow_px_s
from sim.raster.visibility import VisibilityMap
from sim.truth.dense_truth import BACKGROUND, DenseTruth

NOISE = -2
"""Source of an event that no light caused."""
WITHIN_PX = 0.5
"""How far the fastest thing may be from where it is taken to be [px]: half a pixel, less than the
pixel's own reach (assumed)."""
LONGEST_US = 1_000
"""Longest span for which geometry is drawn once [µs] (assumed)."""
SHORTEST_US = 20
"""Shortest likewise (assumed)."""
MEMORY_US = 1_000
"""How long after an object has left a pixel the sensor may still answer to it [µs] (assumed)."""
NEVER = -(1 << 62)
"""A time before all others [µs]."""

F32 = npt.NDArray[np.float32]
I8 = npt.NDArray[np.int8]
I16 = npt.NDArray[np.int16]
I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class EventTruth:
    """Where events came from.

    Attributes:
        source: (n,) int8, number of the object in `Scene.objects`; `BACKGROUND`, -1, for light
            that changed elsewhere: on the street itself, where the camera shakes, a lamp flickers,
            a beam sweeps, or a shadow passes; `NOISE`, -2, where no light changed.
        flow_px_s: (n, 2) float32, x and y: the velocity in the image of that object there, or of
            the street that the pixel's middle shows; not a number for noise.
    """

    source: I8
    flow_px_s: F32


def event_truth(
    events: npt.NDArray[Any],
    causes: npt.ArrayLike,
    crossing: Crossing,
    *,
    light: Collection[int] | int,
    memory_us: int = MEMORY_US,
    within_px: float = WITHIN_PX,
) -> EventTruth:
    """Find where events came from.

    Places are taken at the middle of spans of 1 ms at most, so short that the fastest thing in
    the scene moves `within_px` from it at most; the flow has no error but that place's.

    Args:
        events: (n,) with fields t [µs since the start], x and y [px], sorted by t.
        causes: (n,) why each was fired.
        crossing: what the sensor saw.
        light: the cause, or causes, that mean that light changed.
        memory_us: how long after an object has left a pixel an event may still be its [µs].
        within_px: how far the fastest thing may be from where it is taken to be [px].

    Raises:
        SimError: events out of order or off the sensor; not as many causes; a limit below 0.
    """
    why = np.asarray(causes)
    _check(events, why, crossing, memory_us, within_px)
    wanted = sorted(light) if isinstance(light, Collection) else [light]
    lit = np.flatnonzero(np.isin(why, wanted))
    source = np.full(len(events), NOISE, np.int8)
    flow = np.full((len(events), 2), np.nan, np.float32)
    chosen = events[lit]
    times_us, columns, rows = (np.ascontiguousarray(chosen[name]) for name in "txy")
    geometry = DenseTruth(crossing.scene, crossing.intrinsics)
    past = _Past(crossing.intrinsics.height, crossing.intrinsics.width)
    for start_us, end_us in _spans(crossing, times_us, memory_us, within_px):
        middle_us = (start_us + end_us) // 2
        t_s = crossing.seconds(middle_us)
        visible, twists = geometry.visible(t_s), geometry.twists(t_s)
        flows = flow_px_s(visible, twists, crossing.intrinsics)
        past.note(middle_us, geometry.object_of, visible, flows)
        first, last = np.searchsorted(times_us, [start_us, end_us])
        which = slice(first, last)
        source[lit[which]], flow[lit[which]] = past.ask(
            columns[which], rows[which], flows, middle_us - memory_us
        )
    return EventTruth(source, flow)


def _spans(
    crossing: Crossing, times_us: I64, memory_us: int, within_px: float
) -> Iterator[tuple[int, int]]:
    """Half-open spans that hold all of the times, and as much before each as is remembered [µs]."""
    if not times_us.size:
        return
    start_us, focal_px = max(int(times_us[0]) - memory_us, 0), crossing.intrinsics.focal_px
    while start_us <= times_us[-1]:
        due_us = int(times_us[np.searchsorted(times_us, start_us)]) - memory_us
        start_us = max(start_us, due_us)
        fastest = crossing.scene.fastest_px_s(crossing.seconds(start_us), focal_px)
        length_us = int(np.clip(2e6 * within_px / max(fastest, 1e-9), SHORTEST_US, LONGEST_US))
        yield start_us, start_us + length_us
        start_us += length_us


class _Past:
    """When an object was last at each pixel, which, and how it moved there."""

    def __init__(self, height: int, width: int) -> None:
        self._last_us = np.full((height, width), NEVER, np.int64)
        self._object = np.full((height, width), BACKGROUND, np.int8)
        self._nearness = np.zeros((height, width), np.float32)
        self._flow = np.zeros((height, width, 2), np.float32)

    def note(self, t_us: int, object_of: I8, visible: VisibilityMap, flows: F32) -> None:
        """Take in what is seen at a time, later than all before."""
        here = object_of, visible.body, visible.nearness, flows
        _note(t_us, *here, self._last_us, self._object, self._nearness, self._flow)

    def ask(self, columns: I16, rows: I16, flows: F32, since_us: int) -> tuple[I8, F32]:
        """Whose events at these pixels are: (n,) objects and (n, 2) flows; see `EventTruth`."""
        past = self._last_us, self._object, self._nearness, self._flow
        return _ask(columns, rows, flows, since_us, *past)


@compiled
def _note(
    t_us: int,
    object_of: I8,
    body: I32,
    nearness: F32,
    flows: F32,
    last_us: I64,
    last_object: I8,
    last_nearness: F32,
    last_flow: F32,
) -> None:
    for row in range(body.shape[0]):
        for column in range(body.shape[1]):
            what = body[row, column]
            if what <= 0 or object_of[what] < 0:
                continue
            last_us[row, column] = t_us
            last_object[row, column] = object_of[what]
            last_nearness[row, column] = nearness[row, column]
            last_flow[row, column, 0] = flows[row, column, 0]
            last_flow[row, column, 1] = flows[row, column, 1]


@compiled
def _ask(
    columns: I16,
    rows: I16,
    flows: F32,
    since_us: int,
    last_us: I64,
    last_object: I8,
    last_nearness: F32,
    last_flow: F32,
) -> tuple[I8, F32]:
    """The latest object within reach; of several, that at the pixel itself, else the nearest."""
    height, width = last_us.shape
    source = np.full(len(columns), BACKGROUND, np.int8)
    flow = np.empty((len(columns), 2), np.float32)
    for k in range(len(columns)):
        column, row = columns[k], rows[k]
        flow[k] = flows[row, column]
        best_us, best_nearness = since_us, np.float32(-1.0)
        for y in range(max(row - BLUR_REACH_PX, 0), min(row + BLUR_REACH_PX + 1, height)):
            for x in range(max(column - BLUR_REACH_PX, 0), min(column + BLUR_REACH_PX + 1, width)):
                own = y == row and x == column
                nearness = np.float32(np.inf) if own else last_nearness[y, x]
                later = last_us[y, x] > best_us
                if later or (last_us[y, x] == best_us and nearness > best_nearness):
                    best_us, best_nearness = last_us[y, x], nearness
                    source[k] = last_object[y, x]
                    flow[k] = last_flow[y, x]
    return source, flow


def _check(
    events: npt.NDArray[Any],
    why: npt.NDArray[Any],
    crossing: Crossing,
    memory_us: int,
    within_px: float,
) -> None:
    if why.shape != (len(events),):
        raise SimError(
            f"there are {len(events)} events and causes of shape {why.shape}; allowed is one cause "
            "for each event; pass both as the sensor gave them"
        )
    if not (memory_us >= 0 and within_px > 0):
        raise SimError(
            f"memory_us is {memory_us!r} and within_px {within_px!r}; allowed are 0 µs and more, "
            "and more than 0 px; leave them out for the defaults"
        )
    if not len(events):
        return
    if (np.diff(events["t"]) < 0).any():
        raise SimError("the events go back in time; allowed is sorted by 't'; sort them first")
    for axis, size in (("x", crossing.intrinsics.width), ("y", crossing.intrinsics.height)):
        low, high = int(events[axis].min()), int(events[axis].max())
        if low < 0 or high >= size:
            raise SimError(
                f"an event has {axis} = {low if low < 0 else high}; allowed is 0 to {size - 1}; "
                "pass the crossing that the sensor saw, with the same lens"
            )
