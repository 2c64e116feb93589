"""Every parameter of a run by its dotted name: what it may be, and a run made of some of them."""

from __future__ import annotations

import types
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from difflib import get_close_matches
from enum import StrEnum
from functools import cache
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import msgspec

from detector.fly.config import FlyConfig
from emulator import preset
from emulator.presets import PresetName
from flybench.errors import FlybenchError
from scenarios.errors import ScenarioError
from scenarios.pipeline.registry import DETECTORS, FLY, is_fly
from scenarios.pipeline.run_config import RunConfig
from sim import CrossingConfig

METHOD, SEED, PRESET = "method", "seed", "sensor.preset"
_DAVIS346: PresetName = "davis346"
Settings = Mapping[str, Any]
"""Values by the dotted names of parameters."""
C = TypeVar("C")


@cache
def parameter_types() -> dict[str, Any]:
    """The type of every parameter by its dotted name, in the order of a table's columns."""
    known = dict(_types(RunConfig, ""))
    return {PRESET: PresetName} | known


def _types(kind: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    hints = get_type_hints(kind)
    for field in fields(kind):
        plain = _without_none(hints[field.name])
        if is_dataclass(plain):
            yield from _types(plain, f"{prefix}{field.name}.")
        else:
            yield prefix + field.name, plain


def _without_none(kind: Any) -> Any:
    """The type itself where None, which TOML has not, may stand in its place."""
    if get_origin(kind) not in (Union, types.UnionType):
        return kind
    (plain,) = (part for part in get_args(kind) if part is not types.NoneType)
    return plain


@cache
def sections() -> frozenset[str]:
    """Names that hold parameters and are none themselves, such as "crossing.distractors"."""
    parts = (name.split(".")[:-1] for name in parameter_types())
    return frozenset(".".join(part[:n]) for part in parts for n in range(1, len(part) + 1))


def check_name(name: str) -> None:
    """Refuse what is no parameter.

    Raises:
        ScenarioError: there is none of that name; it says which are near.
    """
    known = parameter_types()
    if name in known:
        return
    own, ends = name.rpartition(".")[2], {full.rpartition(".")[2]: full for full in known}
    near = [full for end, full in ends.items() if end == own]
    near += get_close_matches(name, known, n=2)
    near += [full for end, full in ends.items() if own in end]
    near += [ends[end] for end in get_close_matches(own, ends, n=2)]
    nearest = ", ".join(list(dict.fromkeys(near))[:3])
    hint = f"near it are {nearest}" if nearest else "none is near it"
    raise ScenarioError(
        f"{name} is no parameter; {hint}; `flybench sweep --parameters` lists all that are allowed"
    )


def converted(name: str, value: Any) -> Any:
    """A value from TOML as the type of the parameter `name`.

    Raises:
        ScenarioError: it is of another type, or no member of the few that there are.
    """
    kind = parameter_types()[name]
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError:
        raise ScenarioError(f"{name} is {value!r}; allowed is {allowed(kind)}; give one") from None


def allowed(kind: Any) -> str:
    """What a parameter of a type may be, in words; ranges are checked, and told, elsewhere."""
    if get_origin(kind) is Literal:
        return "one of " + ", ".join(f'"{value}"' for value in get_args(kind))
    if get_origin(kind) is tuple:
        return "a list of whole numbers"
    if issubclass(kind, StrEnum):
        return "one of " + ", ".join(f'"{member}"' for member in kind)
    return _WORDS[kind]


_WORDS: dict[type, str] = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "text in quotes",
}


def make_config(settings: Settings) -> RunConfig:
    """The run that has these values, and the defaults for all others.

    Args:
        settings: values of the parameters' own types. "sensor.preset" gives the sensor's other
            parameters; those of the fly are the method's.

    Raises:
        ScenarioError: a value is outside its range, by its dotted name, or does not go with
            another.
    """
    method = settings.get(METHOD, FLY)
    fly = None
    if any(name.startswith("fly.") for name in settings):
        config = DETECTORS[method].config if is_fly(method) else FlyConfig()
        fly = _changed(config, "fly", settings)
    return RunConfig(
        crossing=_changed(CrossingConfig(), "crossing", settings),
        sensor=_changed(preset(settings.get(PRESET, _DAVIS346)), "sensor", settings),
        method=method,
        fly=fly,
        seed=settings.get(SEED, 0),
    )


def _changed(base: C, section: str, settings: Settings) -> C:
    """A section of the configuration with some of its values, and of the sections in it."""
    changes: dict[str, Any] = {}
    for field in fields(base):  # type: ignore[arg-type]
        name, value = f"{section}.{field.name}", getattr(base, field.name)
        if is_dataclass(value):
            changes[field.name] = _changed(value, name, settings)
        elif name in settings:
            changes[field.name] = settings[name]
    try:
        return replace(base, **changes)  # type: ignore[type-var]
    except FlybenchError as error:
        starts_with_field = str(error).split(" ")[0] in {f.name for f in fields(base)}  # type: ignore[arg-type]
        joint = "." if starts_with_field else ": "
        raise ScenarioError(f"{section}{joint}{error}") from error
