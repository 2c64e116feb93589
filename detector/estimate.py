"""The one interface of every detector: events in, motion estimates out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from flybench.events import Events


@dataclass(frozen=True, slots=True)
class MotionEstimate:
    """What a detector says about one window of events.

    Attributes:
        t_us: end of the window, exclusive: no event at or after it was used [µs].
        hs: horizontal system's response in [−1, 1]; rightward is positive.
        vs: vertical system's response in [−1, 1]; downward is positive.
        direction: the winner of the two, or none.
        strength: the larger of |hs| and |vs|, in [0, 1], also where the direction is none.
        response: the horizontal and vertical response before normalisation.
        view_centre_px: (x, y) on which attention rests, continuous pixel coordinates in which
            pixel i spans [i, i + 1) [px].
        roi_px: (x0, y0, x1, y1), the box of the attended region, half-open [px]; None where
            nothing is attended.
    """

    t_us: int
    hs: float
    vs: float
    direction: Direction
    strength: float
    response: tuple[float, float]
    view_centre_px: tuple[float, float]
    roi_px: tuple[int, int, int, int] | None


class Detector(Protocol):
    """A detector of motion direction that reads a stream in chunks of any size.

    It is made with the keywords `width` and `height`, the sensor's size [px], and looks at one
    stream from one sensor. What is no sorted stream from there it refuses with an `EventError`, and
    is then as before. Neither the cuts between chunks nor the calls of `advance` between them may
    change an estimate.
    """

    def push(self, events: Events) -> list[MotionEstimate]:
        """Take the next events of the stream.

        Args:
            events: sorted by t, none older than what was passed or advanced to before.

        Returns:
            The estimates that became due: those whose window ends at or before the last event.
        """
        ...

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Learn that every event before `t_us` was passed.

        Args:
            t_us: time that the stream has reached, exclusive [µs].

        Returns:
            The estimates that became due: those whose window ends at or before `t_us`.
        """
        ...


@runtime_checkable
class FrameDetector(Detector, Protocol):
    """A detector that looks at intensity frames too, or at nothing else.

    Whoever runs detectors calls `push_frame` where there is one (`isinstance` tells), and calls
    `push` and `advance` all the same: one that needs no events answers them with `[]`, or with the
    estimates that their time made due. Calls come in order of time: events before a frame's
    `t_us` are passed before it, later ones after it.
    """

    def push_frame(self, t_us: int, frame: npt.NDArray[np.uint16]) -> list[MotionEstimate]:
        """Take the next frame.

        Args:
            t_us: end of its exposure, not before what was passed or advanced to before [µs].
            frame: (height, width) uint16, raw counts of the APS; not kept and not changed.

        Returns:
            The estimates that became due.
        """
        ...
