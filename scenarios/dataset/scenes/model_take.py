"""A MuJoCo model, its camera and its motion, as the file of a dataset describes them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from flybench.checks import Range
from scenarios.errors import ScenarioError

MODEL, ARGUMENTS = "model", "model.arguments."
KEYFRAMES = "keyframes"
"""The trajectory through the keyframes of the model."""
_TEXTS = ("file", "camera", "trajectory", "light")
_RANGES = {
    "seed": Range(0, 2**32 - 1),
    "duration_s": Range(0.01, 600.0, "s"),
    "step_px": Range(0.05, 8.0, "px"),
    "max_step_ms": Range(0.1, 20.0, "ms"),
    "supersample": Range(1, 8),
}
"""Ranges of the numbers: those of a crossing, and durations that fit into memory (assumed)."""
_LISTS = ("objects",)
Value = str | int | float | bool


@dataclass(frozen=True)
class ModelTake:
    """What a sequence shows, if it is not a street.

    Attributes:
        folder: folder of the dataset's file, from which relative paths start.
        file: model file.
        camera: name of its camera.
        trajectory: `KEYFRAMES`; or a Python function, "package.module:function" or
            "file.py:function".
        light: name of an illumination that replaces the model's lights; None: the model's.
        seed: seed that the function gets.
        duration_s: length of the sequence [s]; None: that of the keyframes.
        step_px: farthest motion in the image between two rendered samples [px].
        max_step_ms: longest time between two rendered samples [ms].
        supersample: rendered pixels per sensor pixel and axis.
        objects: names of the bodies that are objects; empty: see `MovingModel`.
        arguments: names and values of further arguments of the function.
    """

    folder: Path
    file: str
    camera: str
    trajectory: str
    light: str | None = None
    seed: int = 0
    duration_s: float | None = None
    step_px: float = 0.5
    max_step_ms: float = 5.0
    supersample: int = 2
    objects: tuple[str, ...] = ()
    arguments: tuple[tuple[str, Value], ...] = ()

    @property
    def path(self) -> Path:
        """Path of the model file."""
        return self.folder / self.file

    def parameters(self) -> dict[str, Any]:
        """Return every parameter by name, ready for JSON, without the folder."""
        plain = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "folder"}
        objects = ", ".join(self.objects)
        return plain | {"objects": objects, "arguments": dict(self.arguments)}


def model_take(folder: Path, settings: Mapping[str, Any]) -> ModelTake:
    """Return the take with these values.

    Args:
        folder: folder of the dataset's file.
        settings: values by dotted name, such as "model.file".

    Raises:
        ScenarioError: a key is missing, or keyframes are given a duration or arguments.
    """
    values = {name.removeprefix(f"{MODEL}."): value for name, value in settings.items()}
    arguments = tuple(
        (name.removeprefix(ARGUMENTS), value)
        for name, value in settings.items()
        if name.startswith(ARGUMENTS)
    )
    for key, example in (("file", "arm.xml"), ("camera", "eye"), ("trajectory", KEYFRAMES)):
        if key not in values:
            raise ScenarioError(
                f"{MODEL}.{key} is missing. Allowed is text in quotes. Write, for example, "
                f'{key} = "{example}" in [{MODEL}].'
            )
    _check_trajectory(values, arguments)
    known = {f.name for f in fields(ModelTake)} - {"folder", "arguments"}
    chosen = {name: value for name, value in values.items() if name in known}
    return ModelTake(folder, arguments=arguments, **chosen)


def _check_trajectory(values: Mapping[str, Any], arguments: tuple[Any, ...]) -> None:
    trajectory, duration_s = values["trajectory"], values.get("duration_s")
    if trajectory != KEYFRAMES and duration_s is None:
        raise ScenarioError(
            f"{MODEL}.duration_s is missing, and the trajectory is {trajectory!r}. Allowed is a "
            f"number of seconds. Write, for example, duration_s = 1.0 in [{MODEL}]."
        )
    if trajectory == KEYFRAMES and (duration_s is not None or arguments):
        key = f"{MODEL}.duration_s" if duration_s is not None else f"[{ARGUMENTS[:-1]}]"
        raise ScenarioError(
            f'{key} is set, and the trajectory is "{KEYFRAMES}", whose times are in the model. '
            "Allowed is one of them. Remove it, or name a Python function as trajectory."
        )


def model_value(name: str, value: Any) -> Any:
    """Return a checked value of a parameter of the table `model`.

    Raises:
        ScenarioError: there is no such parameter, or the value has another type or is out of range.
    """
    if name.startswith(ARGUMENTS):
        return _argument(name, value)
    key = name.removeprefix(f"{MODEL}.")
    if key in _TEXTS:
        if not isinstance(value, str) or not value.strip():
            raise ScenarioError(f"{name} is {value!r}. Allowed is text in quotes. Correct it.")
        return value
    if key in _RANGES:
        return _RANGES[key].check(name, value, ScenarioError)
    if key in _LISTS:
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise ScenarioError(
                f"{name} is {value!r}. Allowed is a list of names of bodies in quotes. Correct it."
            )
        return tuple(dict.fromkeys(value))
    allowed = (*_TEXTS, *_RANGES, *_LISTS, "arguments")
    near = get_close_matches(key, allowed, n=1)
    hint = f"Did you mean {near[0]}?" if near else "Correct the name or leave it out."
    raise ScenarioError(f"There is no key {name}. Allowed is {', '.join(allowed)}. {hint}")


def _argument(name: str, value: Any) -> Value:
    if not name.removeprefix(ARGUMENTS).isidentifier():
        raise ScenarioError(
            f"{name} is no name of an argument in Python. Allowed are letters, digits and _. "
            "Correct the name."
        )
    is_finite = not isinstance(value, float) or math.isfinite(value)
    if not isinstance(value, Value) or not is_finite:
        raise ScenarioError(
            f"{name} is {value!r}. Allowed is a finite number, true, false or text in quotes. "
            "Correct the value."
        )
    return value
