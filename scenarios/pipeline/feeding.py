"""Feed a detector with events and frames, and check what it returns.

Every command runs its detectors through `DetectorFeed`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from detector import Detector, FlyMaps, FrameDetector, MotionEstimate
from emulator import ApsFrame
from flybench.events import Events
from flybench.memory import MemoryBudgetError
from scenarios.errors import MethodError, describe, is_interrupt
from scenarios.pipeline.estimate_checks import EstimateChecks
from scenarios.pipeline.read_only import read_only_copy, wrote_to_read_only


class DetectorFeed:
    """A detector on the stream of one sensor, and the reason why it failed, if it did.

    A detector fails if it raises an error or returns anything but valid estimates. It gets no
    further events then, and its estimates until then are kept.

    Attributes:
        method: name of the detector.
        detector: the detector.
        failure: error that names the detector and the cause; None while it works.
    """

    def __init__(self, method: str, detector: Detector, *, width: int, height: int) -> None:
        """Start a stream.

        Args:
            method: name of the detector, for messages.
            detector: fresh detector that follows the protocol `detector.Detector`.
            width: sensor columns [px].
            height: sensor rows [px].
        """
        self.method, self.detector = method, detector
        self.failure: MethodError | None = None
        self._checks = EstimateChecks(method, width, height)
        self._takes_frames = isinstance(detector, FrameDetector)
        self._last_us, self._now_us = -1, 0

    def feed(
        self, events: Events, *, until_us: int, frames: Sequence[ApsFrame] = ()
    ) -> list[MotionEstimate]:
        """Pass the next events and frames to the detector, then advance its time.

        Args:
            events: next events of the stream; the detector gets a read-only copy.
            until_us: time up to which all events have been passed [µs].
            frames: next APS frames of the sensor; only a `FrameDetector` receives them.

        Returns:
            The new estimates, in order of time, until the detector fails; see `failure`.

        Raises:
            MemoryBudgetError: the detector needs more memory than the budget allows.
            MemoryError: memory ran out.
        """
        estimates: list[MotionEstimate] = []
        if self.failure is None:
            try:
                for estimate in self._answers(events, until_us, frames):
                    estimates.append(estimate)  # noqa: PERF402  (keeps those before an error)
            except MethodError as error:
                self.failure = error
        return estimates

    def raise_failure(self) -> None:
        """Raise the reason why the detector failed, if it did.

        Raises:
            MethodError: the detector failed.
        """
        if self.failure is not None:
            raise self.failure

    def _answers(
        self, events: Events, until_us: int, frames: Sequence[ApsFrame]
    ) -> Iterator[MotionEstimate]:
        events, taken = read_only_copy(events), 0
        for frame in frames if self._takes_frames else ():
            cut = int(np.searchsorted(events["t"], frame.end_us))
            yield from self._push(events[taken:cut])
            image = read_only_copy(frame.image)
            yield from self._call("push_frame", frame.end_us, frame.end_us, image)
            taken = cut
        yield from self._push(events[taken:])
        yield from self._call("advance", until_us, until_us)

    def _push(self, events: Events) -> Iterator[MotionEstimate]:
        end_us = int(events["t"][-1]) + 1 if events.size else 0
        return self._call("push", end_us, events)

    def _call(self, name: str, reached_us: int, *arguments: Any) -> Iterator[MotionEstimate]:
        """Call a method of the detector, and check its answer.

        Args:
            name: name of the method.
            reached_us: time that the stream has reached with this call [µs].
            arguments: its arguments.
        """
        self._now_us = max(self._now_us, reached_us)
        try:
            answer = getattr(self.detector, name)(*arguments)
        except (MemoryBudgetError, MemoryError):  # the user can choose something smaller
            raise
        except BaseException as error:  # a detector may raise an error of its own class
            if is_interrupt(error):
                raise
            if wrote_to_read_only(error):
                raise MethodError(
                    f"{self.method}: {name} writes into an array that it was given: "
                    f"{describe(error)}. Allowed is only reading. Copy first, for example with "
                    "events = events.copy()."
                ) from error
            raise MethodError(
                f"{self.method}: {name} raised an error after {self._now_us} µs of "
                f"the stream: {describe(error)}. Correct the detector."
            ) from error
        for estimate in self._checks.checked(
            answer, name, after_us=self._last_us, until_us=self._now_us
        ):
            self._last_us = estimate.t_us
            yield estimate


def fly_maps(detector: Detector) -> FlyMaps | None:
    """Return the maps of a fly at its last estimate; None for other detectors."""
    maps = getattr(detector, "maps", None)
    return maps if isinstance(maps, FlyMaps) else None
