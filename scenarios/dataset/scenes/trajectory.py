"""Trajectories of models: keyframes, or a Python function that the user wrote."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from flybench.memory import MemoryBudgetError
from flybench.sources import add_file
from scenarios.dataset.scenes.model_take import KEYFRAMES, ModelTake
from scenarios.errors import ScenarioError, describe, is_interrupt
from sim.motion.model_keyframes import KeyframeMotion
from sim.moving_model import Place

_KEY = "model.trajectory"


def trajectory_of(take: ModelTake, model: Any) -> tuple[Place, float]:
    """Return the function that places the model at a time [s], and the duration [s].

    A Python function is called once as `function(model, seed=..., **arguments)`, and returns the
    function `place(data, t_s)`.

    Raises:
        ScenarioError: the function does not exist, does not take these arguments, or fails.
        SceneConfigError: the keyframes have no increasing times.
    """
    if take.trajectory == KEYFRAMES:
        motion = KeyframeMotion(model)
        return motion.place, motion.duration_s
    factory = _find(take)
    arguments = dict(take.arguments)
    try:
        inspect.signature(factory).bind(model, seed=take.seed, **arguments)
    except TypeError as error:
        raise ScenarioError(
            f"{_KEY} is {take.trajectory!r}, which cannot be called with (model, seed=..., "
            f"{', '.join(f'{name}=...' for name in arguments)}): {error}. Allowed is a function "
            "with these parameters. Correct it, or [model.arguments]."
        ) from error
    place = _guarded(take, lambda: factory(model, seed=take.seed, **arguments))
    if not callable(place):
        raise ScenarioError(
            f"{_KEY} is {take.trajectory!r}, which returns {place!r}. Allowed is a function "
            "place(data, t_s) that sets data.qpos. Return one."
        )

    def guarded_place(data: Any, t_s: float) -> None:
        _guarded(take, lambda: place(data, t_s))

    if take.duration_s is None:  # model_take demands one
        raise ScenarioError(f"model.duration_s is missing for {take.trajectory!r}. Add it.")
    return guarded_place, take.duration_s


def _guarded(take: ModelTake, call: Callable[[], Any]) -> Any:
    """Call code of the user, and say in one sentence how it fails."""
    try:
        return call()
    except (MemoryBudgetError, MemoryError):
        raise
    except BaseException as error:
        if is_interrupt(error):
            raise
        raise ScenarioError(
            f"{_KEY} is {take.trajectory!r}, which fails: {describe(error)}. Allowed is a function "
            "that works for every time from 10 µs before the start to 10 µs after the end. Correct "
            "it."
        ) from error


def add_sources(digest: Any, take: ModelTake) -> None:
    """Add the file of the trajectory to a digest; modules that it imports are not added."""
    if take.trajectory != KEYFRAMES:
        path = Path(inspect.getfile(_module(*_split(take)[:2])))
        add_file(digest, path.name, path.read_bytes())


def digest_of(take: ModelTake, model_bytes: bytes) -> str:
    """Return a digest of the compiled model and the file of the trajectory."""
    digest = hashlib.sha256(model_bytes)
    add_sources(digest, take)
    return digest.hexdigest()


def _find(take: ModelTake) -> Callable[..., Any]:
    module_name, folder, function_name = _split(take)
    module = _module(module_name, folder)
    found = getattr(module, function_name, None)
    if not callable(found):
        names = [n for n, v in vars(module).items() if inspect.isfunction(v) and n[0] != "_"]
        raise ScenarioError(
            f"{_KEY} is {take.trajectory!r}, and {module_name} has no function {function_name}. "
            f"Allowed is one of {', '.join(names) or 'none'}. Correct the name."
        )
    function: Callable[..., Any] = found
    return function


def _split(take: ModelTake) -> tuple[str, Path, str]:
    module, colon, function = take.trajectory.rpartition(":")
    if not (colon and module and function.isidentifier()):
        raise ScenarioError(
            f'{_KEY} is {take.trajectory!r}. Allowed is "{KEYFRAMES}", "package.module:function" '
            'or "file.py:function". Choose one of these forms.'
        )
    return module, take.folder, function


@cache
def _module(name: str, folder: Path) -> ModuleType:
    """Import a module by its dotted name, or from a file whose path starts at a folder."""
    try:
        if name.endswith(".py"):
            return _from_file(folder / name)
        here = str(Path.cwd())
        if here not in sys.path:  # an installed command does not search the current folder
            sys.path.append(here)
        return importlib.import_module(name)
    except BaseException as error:
        if is_interrupt(error):
            raise
        raise ScenarioError(
            f"{_KEY} names {name}, which cannot be imported: {describe(error)}. Allowed is a file "
            "whose path starts at the folder of the dataset's file, or a module on Python's search "
            "path. Correct this first."
        ) from error


def _from_file(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"flybench_trajectory_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
