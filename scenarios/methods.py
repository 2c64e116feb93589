"""Detectors by name: what `--method` takes."""

from __future__ import annotations

import importlib
import inspect
import itertools
import sys
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

import numpy as np

from detector.contrast_maximisation import ContrastMaximisation
from detector.estimate import Detector, Direction, FrameDetector, MotionEstimate
from detector.fly import FlyDetector
from detector.fly_config import FlyConfig
from detector.frame_fly import FrameFly, FrameFlyConfig
from detector.plane_fit import PlaneFit
from emulator import ApsFrame, Events
from scenarios.errors import ScenarioError

FLY, WIDE = "fly", "wide"
FLY_PRESETS = {FLY: FlyConfig.preset("paper"), WIDE: FlyConfig.preset("wide")}
"""The fly's parameters by the name of the method: the paper's, and those for more speeds."""
FRAME_FLY, CONTRAST, PLANE_FIT = "frame-fly", "contrast-maximisation", "plane-fit"
COARSE_FRAME_FLY, FLOORLESS_FRAME_FLY = "frame-fly-coarse", "frame-fly-no-floor"
VELOCITY_METHODS = frozenset({CONTRAST, PLANE_FIT})
"""Those whose `MotionEstimate.response` is the image velocity itself [px/s]."""
_CALLS = ("push", "advance")
_NUMBERS = ("t_us", "hs", "vs", "strength", "response", "view_centre_px")
_SPANS = {"hs": (-1, 1), "vs": (-1, 1), "strength": (0, 1)}
"""Lowest and highest value of what is normalised."""
_PAIRS = ("response", "view_centre_px")


class MethodError(ScenarioError):
    """A detector that is not there, or does not obey `detector.estimate.Detector`."""


class MakeDetector(Protocol):
    """A detector's class, or a function in its place."""

    def __call__(self, *, width: int, height: int) -> Detector:
        """Make a fresh detector for a sensor of this size [px]."""
        ...


@dataclass(frozen=True)
class Method:
    """A detector that runs in every command.

    Attributes:
        name: as given; it stands in tables and files.
        make: makes a fresh one.
    """

    name: str
    make: MakeDetector


def find_method(name: str) -> Method:
    """The detector of a name.

    Args:
        name: of `FLY_PRESETS` or `BASELINES`, or "package.module:Class", importable from where
            Python looks or from the folder that one is in.

    Raises:
        MethodError: there is no such name, module or class, or it does not obey the protocol.
    """
    if name in FLY_PRESETS:
        return Method(name, fly_maker(FLY_PRESETS[name]))
    if name in BASELINES:
        return Method(name, BASELINES[name])
    module_name, colon, class_name = name.partition(":")
    if not (colon and class_name and module_name):
        raise MethodError(
            f"the method is {name!r}; allowed is {', '.join([*FLY_PRESETS, *BASELINES])}, or a "
            "class of your own as package.module:Class"
        )
    return Method(name, _users_class(name, _module(module_name, name), class_name))


def fly_maker(config: FlyConfig) -> MakeDetector:
    """What makes flies of these parameters."""

    def make(*, width: int, height: int) -> Detector:
        return FlyDetector(config, width=width, height=height)

    return make


def _coarse_frame_fly(*, width: int, height: int) -> Detector:
    return FrameFly(FrameFlyConfig.preset("coarse"), width=width, height=height)


def _floorless_frame_fly(*, width: int, height: int) -> Detector:
    return FrameFly(FrameFlyConfig(snr_floor=0.0), width=width, height=height)


BASELINES: dict[str, MakeDetector] = {
    FRAME_FLY: FrameFly,
    COARSE_FRAME_FLY: _coarse_frame_fly,
    FLOORLESS_FRAME_FLY: _floorless_frame_fly,
    CONTRAST: ContrastMaximisation,
    PLANE_FIT: PlaneFit,
}
"""What the fly is compared with, by the name of the method."""


def read(
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


def _module(module_name: str, method: str) -> ModuleType:
    here = str(Path.cwd())
    if here not in sys.path:  # the installed command looks beside itself, not here
        sys.path.append(here)
    try:
        return importlib.import_module(module_name)
    except Exception as error:
        if isinstance(error, ModuleNotFoundError) and _is_part(error.name, module_name):
            raise MethodError(
                f"the method {method} names the module {module_name}, and there is no "
                f"{error.name} in {here} or where Python looks; call flybench in the folder that "
                "holds it, or set PYTHONPATH"
            ) from error
        raise MethodError(
            f"the module {module_name} of the method {method} cannot be imported: "
            f"{_told(error)}; mend it first"
        ) from error


def _is_part(missing: str | None, module_name: str) -> bool:
    return missing is not None and f"{module_name}.".startswith(f"{missing}.")


def _users_class(method: str, module: ModuleType, class_name: str) -> MakeDetector:
    found: Any = getattr(module, class_name, None)
    if found is None:
        raise MethodError(
            f"the module {module.__name__} has no class {class_name}; {_offered(module)}"
        )
    missing = [call for call in _CALLS if not callable(getattr(found, call, None))]
    if not isinstance(found, type) or missing:
        lacks = f"has no method {' or '.join(missing)}" if missing else "is no class"
        raise MethodError(
            f"{method} {lacks}; allowed is a class with push(events) and advance(t_us), as "
            f"detector.estimate.Detector says; {_offered(module)}"
        )
    try:
        inspect.signature(found).bind(width=346, height=260)
    except TypeError as error:
        raise MethodError(
            f"{method} cannot be made with {class_name}(width=346, height=260): {error}; give its "
            "__init__ the keywords width and height, and a default to all others"
        ) from error

    def make(*, width: int, height: int) -> Detector:
        try:
            detector: Detector = found(width=width, height=height)
        except Exception as error:
            raise MethodError(f"{method} could not be made: {_told(error)}") from error
        return detector

    return make


def _offered(module: ModuleType) -> str:
    """Which classes of a module would do."""
    names = [
        name
        for name, value in vars(module).items()
        if inspect.isclass(value)
        and value.__module__ == module.__name__
        and all(callable(getattr(value, call, None)) for call in _CALLS)
    ]
    return f"it offers {', '.join(names)}" if names else "none of its classes obeys the protocol"


def _told(error: Exception) -> str:
    """An error in one line, with where it was raised."""
    if isinstance(error, SyntaxError):
        return f"SyntaxError: {error}"
    *_, last = traceback.extract_tb(error.__traceback__)
    return f"{type(error).__name__}: {error} ({Path(last.filename).name}, line {last.lineno})"
