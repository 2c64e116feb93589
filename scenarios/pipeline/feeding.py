"""Feed a detector with events and frames, and check the estimates that it returns."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from detector import Detector, FlyMaps, FrameDetector, MotionEstimate
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import Events
from scenarios.errors import MethodError
from scenarios.pipeline.read_only import read_only_copy, refuse_writing

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
    earlier: Sequence[MotionEstimate] = (),
) -> list[MotionEstimate]:
    """Pass the next events and frames to a detector, then advance its time.

    Args:
        detector: detector that follows the protocol `detector.Detector`.
        events: next events of the stream; the detector gets a read-only copy.
        until_us: time up to which all events have been passed [µs].
        frames: next APS frames of the sensor; only a `FrameDetector` receives them.
        earlier: estimates returned by earlier calls; only the last one is used, to check the order.

    Returns:
        The new estimates, in order of time.

    Raises:
        MethodError: the detector writes into the arrays that it is given; it does not return a list
            of estimates; an estimate is not later than the one before it; or a field is not finite,
            is out of range, or is not a direction or a box.
    """
    estimates: list[MotionEstimate] = []
    events, taken = read_only_copy(events), 0
    if frames and isinstance(detector, FrameDetector):  # the protocol check takes 40 µs
        for frame in frames:
            cut = int(np.searchsorted(events["t"], frame.end_us))
            estimates += _call(detector, "push", events[taken:cut])
            estimates += _call(detector, "push_frame", frame.end_us, read_only_copy(frame.image))
            taken = cut
    estimates += _call(detector, "push", events[taken:])
    estimates += _call(detector, "advance", until_us)
    _check_order(detector, [*earlier[-1:], *estimates])
    return estimates


def fly_maps(detector: Detector) -> FlyMaps | None:
    """Return the maps of a fly at its last estimate; None for other detectors."""
    maps = getattr(detector, "maps", None)
    return maps if isinstance(maps, FlyMaps) else None


def _call(detector: Detector, call: str, *arguments: Any) -> Sequence[MotionEstimate]:
    with refuse_writing(detector, call):
        answer = getattr(detector, call)(*arguments)
    return _checked(detector, call, answer)


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
        f"{type(detector).__name__}.{call} returned {found}. Allowed is a list of "
        "detector.MotionEstimate. Return an empty list when no estimate is due."
    )


def _check_numbers(detector: Detector, call: str, estimate: MotionEstimate) -> None:
    for name in _NUMBERS:
        value: Any = getattr(estimate, name)
        try:
            finite = bool(np.isfinite(value).all())
        except TypeError:  # not numeric
            finite = False
        if not finite:
            raise MethodError(
                f"{type(detector).__name__}.{call} returned an estimate at {estimate.t_us} µs "
                f"whose {name} is {value!r}. Allowed are finite numbers. When nothing moves, "
                "return 0 and Direction.NONE."
            )


def _check_ranges(detector: Detector, call: str, estimate: MotionEstimate) -> None:
    found = f"{type(detector).__name__}.{call} returned an estimate at {estimate.t_us} µs whose"
    for name, (low, high) in _SPANS.items():
        value: Any = getattr(estimate, name)
        if np.shape(value) != () or not low <= value <= high:
            raise MethodError(
                f"{found} {name} is {value!r}. Allowed is a number from {low} to {high}. Limit it "
                "to this range, for example with math.tanh."
            )
    for name in _PAIRS:
        if np.shape(getattr(estimate, name)) != (2,):
            raise MethodError(
                f"{found} {name} is {getattr(estimate, name)!r}. Allowed are two numbers. Return "
                "one for x and one for y."
            )


def _check_kinds(detector: Detector, call: str, estimate: MotionEstimate) -> None:
    direction: Any = estimate.direction
    box: Any = estimate.roi_px
    if not isinstance(direction, Direction):
        raise MethodError(
            f"{type(detector).__name__}.{call} returned an estimate at {estimate.t_us} µs whose "
            f"direction is {direction!r}. Allowed is a detector.Direction, such as "
            "Direction.RIGHT. Convert a string with Direction(string)."
        )
    if box is not None and not _is_box(box):
        raise MethodError(
            f"{type(detector).__name__}.{call} returned an estimate at {estimate.t_us} µs whose "
            f"roi_px is {box!r}. Allowed is (x0, y0, x1, y1) with 0 ≤ x0 < x1 and 0 ≤ y0 < y1. "
            "Return None if there is no region of interest."
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
                f"{before.t_us} µs. Allowed are estimates whose t_us increases. Return one "
                "estimate per window, in order of time."
            )
