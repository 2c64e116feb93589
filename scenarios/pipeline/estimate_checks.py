"""The checks on the estimates of a detector, which run when an estimate comes."""

from __future__ import annotations

import reprlib
from collections.abc import Iterator
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

from detector import MotionEstimate
from flybench.direction import Direction
from scenarios.errors import MethodError

VIEW_MARGIN = 1
"""Distance from the image at which a view centre may still lie, in image sizes (assumed: a
detector may extrapolate an object that has left the image)."""
MAX_RESPONSE = 1e12
"""Greatest absolute response (assumed: far above any image velocity, and its square is finite)."""

_REPR = reprlib.Repr()
_REPR.maxother = _REPR.maxstring = 60


@dataclass(frozen=True)
class EstimateChecks:
    """The checks on the estimates of one detector, and its name for the messages.

    Attributes:
        method: name of the detector.
        width: sensor columns [px].
        height: sensor rows [px].
    """

    method: str
    width: int
    height: int

    def checked(
        self, answer: Any, call: str, *, after_us: int, until_us: int
    ) -> Iterator[MotionEstimate]:
        """Yield the estimates of an answer, with their numbers as Python's int and float.

        Args:
            answer: what the detector returned.
            call: name of the method that returned it.
            after_us: time of the estimate before; -1 if there is none [µs].
            until_us: time that the stream has reached [µs].

        Raises:
            MethodError: the answer is no list; or an estimate is of another class, is not later
                than the one before it, is later than the stream, or has a field of a wrong type or
                out of its range. Those before it have been yielded.
        """
        if not isinstance(answer, list):
            raise self._not_a_list(call, type(answer).__name__)
        for estimate in answer:
            if not isinstance(estimate, MotionEstimate):
                raise self._not_a_list(call, f"a list with {type(estimate).__name__}")
            whose = f"{self.method}: {call} returned an estimate at {short(estimate.t_us)} µs whose"
            after_us = self._time(whose, estimate.t_us, after_us, until_us)
            yield MotionEstimate(
                t_us=after_us,
                hs=_number(f"{whose} hs", estimate.hs, -1, 1),
                vs=_number(f"{whose} vs", estimate.vs, -1, 1),
                direction=_direction(f"{whose} direction", estimate.direction),
                strength=_number(f"{whose} strength", estimate.strength, 0, 1),
                response=_response(f"{whose} response", estimate.response),
                view_centre_px=self._view_centre(f"{whose} view_centre_px", estimate),
                roi_px=self._box(f"{whose} roi_px", estimate.roi_px),
            )

    def _not_a_list(self, call: str, found: str) -> MethodError:
        return MethodError(
            f"{self.method}: {call} returned {found}. Allowed is a list of "
            "detector.MotionEstimate. Return an empty list when no estimate is due."
        )

    def _time(self, whose: str, t_us: Any, after_us: int, until_us: int) -> int:
        if not _is_whole(t_us) or t_us < 0:
            raise MethodError(
                f"{whose} t_us is {short(t_us)}. Allowed is a whole number of µs from 0. Convert "
                "it with int()."
            )
        if t_us <= after_us:
            raise MethodError(
                f"{whose} t_us is not later than the one before it, at {after_us} µs. Allowed are "
                "estimates whose t_us increases. Return one estimate per window, in order of time."
            )
        if t_us > until_us:
            raise MethodError(
                f"{whose} t_us is later than the stream, which has reached {until_us} µs. Allowed "
                "is the end of a window that has ended. Return the estimate when its window ends."
            )
        return int(t_us)

    def _view_centre(self, name: str, estimate: MotionEstimate) -> tuple[float, float]:
        x, y = _pair(name, estimate.view_centre_px)
        sides = (("x", x, self.width), ("y", y, self.height))
        first, second = (
            _number(f"{name} {side}", value, -VIEW_MARGIN * size, (1 + VIEW_MARGIN) * size)
            for side, value, size in sides
        )
        return first, second

    def _box(self, name: str, box: Any) -> tuple[int, int, int, int] | None:
        if box is None:
            return None
        sides = _items(box, 4)
        if sides is not None and all(map(_is_whole, sides)):
            x0, y0, x1, y1 = map(int, sides)
            if 0 <= x0 < x1 <= self.width and 0 <= y0 < y1 <= self.height:
                return x0, y0, x1, y1
        raise MethodError(
            f"{name} is {short(box)}. Allowed is (x0, y0, x1, y1) in whole pixels, with 0 ≤ x0 < "
            f"x1 ≤ {self.width} and 0 ≤ y0 < y1 ≤ {self.height}. Return None if there is no "
            "region of interest."
        )


def short(value: Any) -> str:
    """Return the representation of a value, shortened and on one line."""
    return " ".join(_REPR.repr(value).split())


def _number(name: str, value: Any, low: float, high: float) -> float:
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    if is_number and low <= value <= high:
        return float(value)
    raise MethodError(
        f"{name} is {short(value)}. Allowed is a number from {low:g} to {high:g}. Limit it to this "
        "range; when nothing moves, return 0 and Direction.NONE."
    )


def _response(name: str, value: Any) -> tuple[float, float]:
    first, second = (
        _number(name, each, -MAX_RESPONSE, MAX_RESPONSE) for each in _pair(name, value)
    )
    return first, second


def _pair(name: str, value: Any) -> tuple[Any, Any]:
    items = _items(value, 2)
    if items is None:
        raise MethodError(
            f"{name} is {short(value)}. Allowed are two numbers. Return one for x and one for y."
        )
    return items[0], items[1]


def _direction(name: str, value: Any) -> Direction:
    if not isinstance(value, Direction):
        raise MethodError(
            f"{name} is {short(value)}. Allowed is a detector.Direction, such as Direction.RIGHT. "
            "Convert a string with Direction(string)."
        )
    return value


def _items(value: Any, count: int) -> tuple[Any, ...] | None:
    """Return the items of a tuple, list or array of this length; None for anything else."""
    try:
        items = tuple(value)
    except TypeError:
        return None
    return items if len(items) == count and not isinstance(value, str) else None


def _is_whole(value: Any) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool)
