"""A detector behind a filter: it sees only the events that the filter keeps."""

from __future__ import annotations

from typing import Any

from detector.denoise.event_filter import EventFilter
from detector.estimate import Detector, FrameDetector, MotionEstimate
from detector.event_checks import check_chunk
from flybench.events import Events


class FilteredDetector:
    """A `Detector` whose events pass a filter first.

    Attributes:
        filter: the filter.
        detector: the detector.
    """

    def __init__(self, event_filter: EventFilter, detector: Detector) -> None:
        self.filter, self.detector = event_filter, detector
        self._now_us = 0

    def push(self, events: Events) -> list[MotionEstimate]:
        """Pass the events that the filter keeps to the detector; see `Detector.push`.

        Raises:
            EventError: the chunk is not a sorted stream of `EVENT_DTYPE` from this sensor.
            EventOrderError: the first event is before an event or a time that was passed before.
        """
        size = {"width": self.filter.width, "height": self.filter.height}
        check_chunk(events, **size, now_us=self._now_us)
        if not events.size:
            return []
        estimates = self.detector.push(self.filter.keep(events))
        return estimates + self.advance(int(events["t"][-1]))

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Declare that every event before `t_us` has been passed; see `Detector.advance`."""
        estimates = self.detector.advance(t_us)
        self._now_us = t_us
        return estimates

    @property
    def maps(self) -> Any:
        """Maps behind the last estimate of a fly; None for other detectors."""
        return getattr(self.detector, "maps", None)

    @property
    def memory_us(self) -> Any:
        """Age of the oldest event in an estimate [µs]; 0 if the detector does not state it."""
        return getattr(self.detector, "memory_us", 0)


class FilteredFrameDetector(FilteredDetector):
    """A `FrameDetector` whose events pass a filter first; frames do not."""

    detector: FrameDetector

    def push_frame(self, t_us: int, image: Any) -> list[MotionEstimate]:
        """Pass a frame on; see `FrameDetector.push_frame`."""
        return self.detector.push_frame(t_us, image)


def filtered(event_filter: EventFilter, detector: Detector) -> FilteredDetector:
    """Return a detector behind a filter; it takes frames if the detector takes frames."""
    if isinstance(detector, FrameDetector):
        return FilteredFrameDetector(event_filter, detector)
    return FilteredDetector(event_filter, detector)
