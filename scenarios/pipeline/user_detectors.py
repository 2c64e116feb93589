"""Detectors by name: ours from the registry, a user's from a class of their own."""

from __future__ import annotations

import importlib
import inspect
import sys
import traceback
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

from detector import Detector
from scenarios.errors import MethodError
from scenarios.pipeline.registry import DETECTORS, DetectorEntry

_CALLS = ("push", "advance")


class MakeDetector(Protocol):
    """A detector's class, or a function in its place."""

    def __call__(self, *, width: int, height: int) -> Detector:
        """Return a fresh detector for a sensor of this size [px]."""
        ...


@dataclass(frozen=True)
class UserDetector:
    """A detector class of the user's own.

    Attributes:
        name: as the user gave it: "package.module:Class".
        make: returns a fresh detector for a sensor of a given size.
    """

    name: str
    make: MakeDetector


def find_method(name: str) -> DetectorEntry | UserDetector:
    """Return the detector of a name.

    Args:
        name: a name in `DETECTORS`, or "package.module:Class" for a class that Python can import
            from where it looks for modules or from the current folder.

    Raises:
        MethodError: there is no such name, module or class, or the class does not obey the
            protocol `detector.Detector`.
    """
    if name in DETECTORS:
        return DETECTORS[name]
    module_name, colon, class_name = name.partition(":")
    if not (colon and class_name and module_name):
        raise MethodError(
            f"The method is {name!r}. Allowed is {', '.join(DETECTORS)}, or a class of your own as "
            "package.module:Class."
        )
    return UserDetector(name, _users_class(name, _module(module_name, name), class_name))


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
