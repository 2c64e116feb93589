"""How a detector is fed: events, then frames, then the time reached; its answers are checked."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from detector import Detector, FrameDetector, MotionEstimate
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import Events
from scenarios.errors import MethodError

_NUMBERS = ("t_us", "hs", "vs", "strength", "response", "view_centre_px")
_SPANS = {"hs": (-1, 1), "vs": (-1, 1), "strength": (0, 1)}
"""Lowest and highest value of each normalised field of an estimate."""
_PAIRS = ("response", "view_centre_px")


def feed(
    detector: Detector,
    events: Events,
    *,
    until_us: int,
    frames: Sequence[ApsFrame] = (),
    said: Sequence[MotionEstimate] = (),
) -> list[MotionEstimate]:
    """Pass the next events and frames, and say how far time has come.

    Args:
        detector: any that obeys the protocol.
        events: the next of the stream.
        until_us: every event before this was passed [µs].
        frames: the next of the sensor's; for a `FrameDetector`.
        said: what it answered before, of which the last is looked at.

    Raises:
        MethodError: what it answers is no list of estimates, or one of them is no later than the
            one before, or holds what is no finite number, outside its range, no direction or no
            box.
    """
    estimates: list[MotionEstimate] = []
    taken = 0
    if frames and isinstance(detector, FrameDetector):  # to ask a protocol takes 40 µs
        for frame in frames:
            cut = int(np.searchsorted(events["t"], frame.end_us))
            estimates += _checked(detector, "push", detector.push(events[taken:cut]))
            answer = detector.push_frame(frame.end_us, frame.image)
            estimates += _checked(detector, "push_frame", answer)
            taken = cut
    estimates += _checked(detector, "push", detector.push(events[taken:]))
    estimates += _checked(detector, "advance", detector.advance(until_us))
    _check_order(detector, [*said[-1:], *estimates])
    return estimates


def _checked(detector: Detector, call: str, answer: Any) -> Sequence[MotionEstimate]:
    if isinstance(answer, list) and all(isinstance(e, MotionEstimate) for e in answer):
        for estimate in answer:
            _check_numbers(detector, call, estimate)
            _check_ranges(detector, call, estimate)
            _check_kinds(detector, call, estimate)
        return answer
    kinds = {type(e).__name__ for e in answer} if isinstance(answer, list) else set()
    found = f"a list of {', '.join(sorted(kinds))}" if kinds else type(answer).__name__
    raise MethodError(
        f"{type(detector).__name__}.{call} returned {found}; allowed is a list of "
        "detector.estimate.MotionEstimate, empty where none is due"
    )


def _check_numbers(detector: Detector, call: str, estimate: MotionEstimate) -> None:
    for name in _NUMBERS:
        value: Any = getattr(estimate, name)
        try:
            finite = bool(np.isfinite(value).all())
        except TypeError:  # no numbers at all
            finite = False
        if not finite:
            raise MethodError(
                f"{type(detector).__name__}.{call} returned an estimate at {estimate.t_us} µs "
                f"whose {name} is {value!r}; allowed are finite numbers; where nothing is seen, "
                "give 0 and Direction.NONE"
            )


def _check_ranges(detector: Detector, call: str, estimate: MotionEstimate) -> None:
    found = f"{type(detector).__name__}.{call} returned an estimate at {estimate.t_us} µs whose"
    for name, (low, high) in _SPANS.items():
        value: Any = getattr(estimate, name)
        if np.shape(value) != () or not low <= value <= high:
            raise MethodError(
                f"{found} {name} is {value!r}; allowed is {low} to {high}; bring it there, with "
                "math.tanh for example"
            )
    for name in _PAIRS:
        if np.shape(getattr(estimate, name)) != (2,):
            raise MethodError(
                f"{found} {name} is {getattr(estimate, name)!r}; allowed are two numbers, one "
                "along x and one along y"
            )


def _check_kinds(detector: Detector, call: str, estimate: MotionEstimate) -> None:
    direction: Any = estimate.direction
    box: Any = estimate.roi_px
    if not isinstance(direction, Direction):
        raise MethodError(
            f"{type(detector).__name__}.{call} returned an estimate at {estimate.t_us} µs whose "
            f"direction is {direction!r}; allowed is a detector.estimate.Direction, such as "
            "Direction.RIGHT; make one of a word with Direction(word)"
        )
    if box is not None and not _is_box(box):
        raise MethodError(
            f"{type(detector).__name__}.{call} returned an estimate at {estimate.t_us} µs whose "
            f"roi_px is {box!r}; allowed is (x0, y0, x1, y1) with 0 ≤ x0 < x1 and 0 ≤ y0 < y1, or "
            "None where there is no region"
        )


def _is_box(box: Any) -> bool:
    if np.shape(box) != (4,):
        return False
    x0, y0, x1, y1 = box
    return bool(0 <= x0 < x1 and 0 <= y0 < y1)


def _check_order(detector: Detector, estimates: Sequence[MotionEstimate]) -> None:
    for before, after in itertools.pairwise(estimates):
        if after.t_us <= before.t_us:
            raise MethodError(
                f"{type(detector).__name__} returned an estimate at {after.t_us} µs after one at "
                f"{before.t_us} µs; allowed is a t_us that rises from each to the next; give each "
                "window's end once, in order"
            )
