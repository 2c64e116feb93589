"""Ground truth for events: which object each event came from, and the true flow at its pixel.

The geometry is computed once for every short span of time. An event belongs to an object that
covers the middle of the event's pixel or lies within one pixel of it, because the lens blurs light
over that distance. It may do so at the event's time or shortly before, because the sensor responds
with a delay.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from flybench.events import Cause, Events, check_events
from sim.crossing import Crossing
from sim.errors import SimError
from sim.geometry.pinhole import Intrinsics
from sim.raster.flow import flow_px_s
from sim.raster.visibility import VisibilityMap
from sim.truth.dense_truth import DenseTruth
from sim.truth.last_objects import look_up_last, nothing_seen, update_last

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

F32 = npt.NDArray[np.float32]
I8 = npt.NDArray[np.int8]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]


class Geometry(Protocol):
    """Geometry of a scene at any time: `DenseTruth` or `MovingModel`."""

    object_of_body: I8

    @property
    def lens(self) -> Intrinsics:
        """Intrinsics of the camera."""
        ...

    def visible(self, t_s: float, /) -> VisibilityMap:
        """Return the body that the middle of each pixel shows, and its nearness."""
        ...

    def twists(self, t_s: float, /) -> F64:
        """Return the velocity field of each body in the camera's frame."""
        ...


class Clock(NamedTuple):
    """Times and speeds of a scene.

    Attributes:
        seconds: function from the time of an event [µs] to that of the geometry [s].
        fastest_px_s: function from the latter to a bound on the image speed [px/s].
    """

    seconds: Callable[[int], float]
    fastest_px_s: Callable[[float], float]


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
    lens = crossing.intrinsics
    return traced_events(
        events,
        np.asarray(causes),
        DenseTruth(crossing.scene, lens),
        Clock(crossing.seconds, lambda t_s: crossing.scene.fastest_px_s(t_s, lens.focal_px)),
        signal=signal,
        max_delay_us=max_delay_us,
        tolerance_px=tolerance_px,
    )


def traced_events(
    events: Events,
    causes: npt.NDArray[np.generic],
    geometry: Geometry,
    clock: Clock,
    *,
    signal: Collection[int] | int = Cause.SIGNAL,
    max_delay_us: int = MAX_DELAY_US,
    tolerance_px: float = TOLERANCE_PX,
) -> EventTruth:
    """Find the source and the true flow of every event in any scene; see `event_truth`."""
    lens = geometry.lens
    _check(events, causes, lens, max_delay_us, tolerance_px)
    signal_causes = sorted(signal) if isinstance(signal, Collection) else [signal]
    chosen = np.flatnonzero(np.isin(causes, signal_causes))
    source = np.full(len(events), NOISE, np.int8)
    flow = np.full((len(events), 2), np.nan, np.float32)
    times_us, columns, rows = (np.ascontiguousarray(events[name][chosen]) for name in "txy")
    last = nothing_seen(lens.height, lens.width)
    for start_us, end_us in _spans(clock, times_us, max_delay_us, tolerance_px):
        middle_us = (start_us + end_us) // 2
        t_s = clock.seconds(middle_us)
        visible, twists = geometry.visible(t_s), geometry.twists(t_s)
        flow_now = flow_px_s(visible, twists, lens)
        update_last(
            last, middle_us, geometry.object_of_body, visible.body, visible.nearness, flow_now
        )
        within = slice(*np.searchsorted(times_us, [start_us, end_us]))
        source[chosen[within]], flow[chosen[within]] = look_up_last(
            last, columns[within], rows[within], flow_now, middle_us - max_delay_us
        )
    return EventTruth(source, flow)


def _spans(
    clock: Clock, times_us: I64, max_delay_us: int, tolerance_px: float
) -> Iterator[tuple[int, int]]:
    """Half-open spans that cover every event's time and the `max_delay_us` before it [µs]."""
    if not times_us.size:
        return
    start_us = max(int(times_us[0]) - max_delay_us, 0)
    while start_us <= times_us[-1]:
        next_event_us = int(times_us[np.searchsorted(times_us, start_us)])
        start_us = max(start_us, next_event_us - max_delay_us)
        fastest_px_s = clock.fastest_px_s(clock.seconds(start_us))
        length_us = 2e6 * tolerance_px / max(fastest_px_s, 1e-9)
        end_us = start_us + int(np.clip(length_us, MIN_SPAN_US, MAX_SPAN_US))
        yield start_us, end_us
        start_us = end_us


def _check(
    events: Events,
    causes: npt.NDArray[np.generic],
    lens: Intrinsics,
    max_delay_us: int,
    tolerance_px: float,
) -> None:
    check_events(events, width=lens.width, height=lens.height)
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
