"""Find a detector by name: a built-in one, or a class that the user wrote."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

from detector import Detector
from detector.denoise import FILTERS, filtered
from flybench.memory import MemoryBudgetError
from flybench.sources import PACKAGES
from scenarios.errors import MethodError, describe, is_interrupt
from scenarios.pipeline.registry import DETECTORS, DetectorEntry

_REQUIRED_METHODS = ("push", "advance")


class DetectorFactory(Protocol):
    """A detector class, or a function that makes a detector."""

    def __call__(self, *, width: int, height: int) -> Detector:
        """Return a fresh detector for a sensor of this size [px]."""
        ...


@dataclass(frozen=True)
class UserDetector:
    """A detector class that the user wrote, or any detector behind a filter.

    Attributes:
        name: name as the user gave it, "package.module:Class" or "filter+detector".
        make: function that returns a fresh detector for a sensor of a given size.
    """

    name: str
    make: DetectorFactory


def find_method(name: str) -> DetectorEntry | UserDetector:
    """Return the detector with this name.

    Args:
        name: a name in `DETECTORS`, or "package.module:Class" for a class that Python can import
            from the current folder or from its module search path. With the name of a filter and
            "+" before it, such as "stcf+fly", the detector sees only what the filter keeps.

    Raises:
        MethodError: the name, module, class or filter does not exist, or the class does not follow
            the protocol `detector.Detector`.
    """
    if name in DETECTORS:
        return DETECTORS[name]
    before, plus, after = name.partition("+")
    if plus:
        return _behind_filter(name, before, find_method(after))
    module_name, colon, class_name = name.partition(":")
    if not (colon and class_name and module_name):
        raise MethodError(
            f"The method is {name!r}. Allowed is {', '.join(DETECTORS)}, or package.module:Class "
            "for a class of yours. Choose one of them."
        )
    return UserDetector(name, _class_factory(name, _import(module_name, name), class_name))


def _behind_filter(
    name: str, filter_name: str, method: DetectorEntry | UserDetector
) -> UserDetector:
    if filter_name not in FILTERS:
        raise MethodError(
            f"The method is {name!r}, and there is no filter {filter_name!r}. Allowed before the + "
            f"is one of {', '.join(FILTERS)}. Choose one of them, or leave it out."
        )

    def make(*, width: int, height: int) -> Detector:
        event_filter = FILTERS[filter_name](width=width, height=height)
        return filtered(event_filter, method.make(width=width, height=height))

    return UserDetector(name, make)


def _import(module_name: str, method: str) -> ModuleType:
    here = Path.cwd()
    if str(here) not in sys.path:  # an installed command does not search the current folder
        sys.path.append(str(here))
    sys.path.insert(0, str(here))  # the user's folder first, until the module is imported
    try:
        return _from_folder(here, module_name) or importlib.import_module(module_name)
    except BaseException as error:
        if is_interrupt(error):
            raise
        if isinstance(error, ModuleNotFoundError) and _is_part(error.name, module_name):
            raise MethodError(
                f"The method is {method}, but Python finds no module {error.name}. Allowed are "
                f"modules in {here} and on Python's search path. Run flybench in the folder of the "
                "module, or set PYTHONPATH."
            ) from error
        raise MethodError(
            f"The module {module_name} of the method {method} cannot be imported: "
            f"{describe(error)}. Correct this error first."
        ) from error
    finally:
        sys.path.remove(str(here))


def _from_folder(folder: Path, module_name: str) -> ModuleType | None:
    """Return a module of a folder whose package has the name of one that is loaded already.

    Such a package, for example the user's own `detector`, hides behind ours: the module is loaded
    from its file. None: there is no such file, or no other package of that name.
    """
    top, *parts = module_name.split(".")
    file = folder.joinpath(top, *parts).with_suffix(".py")
    if not file.is_file():
        return None
    loaded = importlib.import_module(top) if top in PACKAGES else sys.modules.get(top)
    if loaded is None or _is_in(loaded, folder / top):
        return None
    private = f"{module_name} in {folder}"
    if private in sys.modules:
        return sys.modules[private]
    spec = importlib.util.spec_from_file_location(private, file)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[private] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[private]
        raise
    return module


def _is_in(module: ModuleType, path: Path) -> bool:
    """Return True if a loaded module is the package or the file of this path."""
    file = getattr(module, "__file__", None)
    return file is None or Path(file).is_relative_to(path) or Path(file) == path.with_suffix(".py")


def _is_part(missing: str | None, module_name: str) -> bool:
    return missing is not None and f"{module_name}.".startswith(f"{missing}.")


def _class_factory(method: str, module: ModuleType, class_name: str) -> DetectorFactory:
    found: Any = getattr(module, class_name, None)
    if found is None:
        raise MethodError(
            f"The module {module.__name__} has no class {class_name}. {_available(module)}"
        )
    missing = [call for call in _REQUIRED_METHODS if not callable(getattr(found, call, None))]
    if not isinstance(found, type) or missing:
        lacks = f"has no method {' or '.join(missing)}" if missing else "is not a class"
        raise MethodError(
            f"{method} {lacks}. Allowed is a class with push(events) and advance(t_us), as in the "
            f"protocol detector.Detector. {_available(module)}"
        )
    try:
        inspect.signature(found).bind(width=346, height=260)
    except TypeError as error:
        raise MethodError(
            f"{method} cannot be created with {class_name}(width=346, height=260): {error}. "
            "Allowed is an __init__ with the keywords width and height. Give every other parameter "
            "a default."
        ) from error

    def make(*, width: int, height: int) -> Detector:
        try:
            detector: Detector = found(width=width, height=height)
        except (MemoryBudgetError, MemoryError):  # the user can choose something smaller
            raise
        except BaseException as error:
            if is_interrupt(error):
                raise
            raise MethodError(f"{method} could not be created: {describe(error)}.") from error
        return detector

    return make


def _available(module: ModuleType) -> str:
    """Return a sentence that lists the classes of a module that can be used."""
    names = [
        name
        for name, value in vars(module).items()
        if inspect.isclass(value)
        and value.__module__ == module.__name__
        and all(callable(getattr(value, call, None)) for call in _REQUIRED_METHODS)
    ]
    if not names:
        return "None of its classes follows the protocol."
    return f"Available in this module: {', '.join(names)}."
