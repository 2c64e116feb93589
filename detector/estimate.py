"""The interface of every detector: it takes events and returns motion estimates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from flybench.events import Events
from flybench.printable import html_table


@dataclass(frozen=True, slots=True)
class MotionEstimate:
    """A detector's estimate for one window of events.

    Attributes:
        t_us: end of the window, exclusive: no event at or after it was used [µs].
        hs: response of the horizontal system in [−1, 1]; positive is rightward.
        vs: response of the vertical system in [−1, 1]; positive is downward.
        direction: direction of the stronger system, or `NONE`.
        strength: the larger of |hs| and |vs|, in [0, 1]; also given if the direction is `NONE`.
        response: horizontal and vertical response before normalisation.
        view_centre_px: (x, y) of the point that the detector attends to [px], in continuous pixel
            coordinates: pixel i spans [i, i + 1).
        roi_px: (x0, y0, x1, y1), bounding box of the region of interest, half-open [px]; None if
            the detector attends to nothing.
    """

    t_us: int
    hs: float
    vs: float
    direction: Direction
    strength: float
    response: tuple[float, float]
    view_centre_px: tuple[float, float]
    roi_px: tuple[int, int, int, int] | None

    def _repr_html_(self) -> str:
        rows = {
            "time": f"{self.t_us / 1e6:.3f} s",
            "direction": self.direction.value,
            "strength": f"{self.strength:.3f}",
            "HS, rightward > 0": f"{self.hs:+.3f}",
            "VS, downward > 0": f"{self.vs:+.3f}",
            "view centre": "({:.1f}, {:.1f}) px".format(*self.view_centre_px),
            "region of interest": "none" if self.roi_px is None else f"{self.roi_px} px",
        }
        return html_table("motion estimate", rows)


class Detector(Protocol):
    """A detector of motion direction that reads a stream in chunks of any size.

    It is made with the keywords `width` and `height`, the size of the sensor [px], and reads one
    stream from one sensor. It refuses a chunk that is not a sorted stream from this sensor with an
    `EventError`, and its own state is then unchanged. Neither the cuts between chunks nor calls of
    `advance` between them may change an estimate.
    """

    def push(self, events: Events) -> list[MotionEstimate]:
        """Process the next events of the stream.

        Args:
            events: sorted by t; none earlier than an event or a time that was passed before.

        Returns:
            Estimates of the windows that have ended at or before the last event.
        """
        ...

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Declare that every event before `t_us` has been passed.

        Args:
            t_us: time that the stream has reached, exclusive [µs].

        Returns:
            Estimates of the windows that have ended at or before `t_us`.
        """
        ...


@runtime_checkable
class FrameDetector(Detector, Protocol):
    """A detector that reads intensity frames, with or without events.

    Callers pass frames to `push_frame` if the detector has this method (they test
    `isinstance(detector, FrameDetector)`), and also call `push` and `advance`. A detector that
    needs no events returns `[]` from these, or the estimates that are due by then. Calls come in
    order of time: events before a frame's `t_us` are passed before the frame, later events after
    it.
    """

    def push_frame(self, t_us: int, frame: npt.NDArray[np.uint16]) -> list[MotionEstimate]:
        """Process the next frame.

        Args:
            t_us: end of its exposure [µs]; not before an event or a time that was passed before.
            frame: (height, width) uint16, raw counts of the APS; neither kept nor changed.

        Returns:
            The estimates that are due.
        """
        ...
