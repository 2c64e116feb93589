"""Parameters of a run by their dotted names: their types, and runs made from their values."""

from __future__ import annotations

import types
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from difflib import get_close_matches
from enum import StrEnum
from functools import cache
from typing import Any, Literal, Self, TypeVar, Union, get_args, get_origin, get_type_hints

import msgspec

from detector.fly.config import FlyConfig
from emulator import SensorConfig, preset
from emulator.presets import PresetName
from flybench.direction import Direction
from flybench.errors import FlybenchError
from scenarios.errors import ScenarioError
from scenarios.options.sensor import SensorOptions
from scenarios.pipeline.frame_check import check_frames
from scenarios.pipeline.registry import DETECTORS, FLY, is_fly
from scenarios.pipeline.run_config import RunConfig
from sim import CrossingConfig

METHOD, SEED, PRESET = "method", "seed", "sensor.preset"
_DAVIS346: PresetName = "davis346"
Settings = Mapping[str, Any]
"""Values by the dotted names of parameters."""
C = TypeVar("C")


@dataclass(frozen=True)
class BaseSensor:
    """The sensor of the command line, which the parameters of a file change.

    Attributes:
        config: configuration of the sensor.
        preset: name of its preset.
    """

    config: SensorConfig
    preset: PresetName

    @classmethod
    def of(cls, options: SensorOptions) -> Self:
        """Return the sensor that the options describe."""
        return cls(options.config(), options.preset)


@cache
def parameter_types() -> dict[str, Any]:
    """Return the type of every parameter by its dotted name, in the order of table columns."""
    return {PRESET: PresetName} | dict(_types(RunConfig, ""))


def _types(kind: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    hints = get_type_hints(kind)
    for field in fields(kind):
        plain = _without_none(hints[field.name])
        if is_dataclass(plain):
            yield from _types(plain, f"{prefix}{field.name}.")
        else:
            yield prefix + field.name, plain


def _without_none(kind: Any) -> Any:
    """Return a type without its alternative None, which TOML does not have."""
    if get_origin(kind) not in (Union, types.UnionType):
        return kind
    (plain,) = (part for part in get_args(kind) if part is not types.NoneType)
    return plain


@cache
def sections() -> frozenset[str]:
    """Return the names of groups of parameters, such as "crossing.distractors"."""
    parts = (name.split(".")[:-1] for name in parameter_types())
    return frozenset(".".join(part[:n]) for part in parts for n in range(1, len(part) + 1))


def check_name(name: str) -> None:
    """Check the name of a parameter.

    Raises:
        ScenarioError: there is no such parameter; the message names similar ones.
    """
    known = parameter_types()
    if name in known:
        return
    last, by_last = name.rpartition(".")[2], {full.rpartition(".")[2]: full for full in known}
    similar = [full for part, full in by_last.items() if part == last]
    similar += get_close_matches(name, known, n=2)
    similar += [full for part, full in by_last.items() if last in part]
    similar += [by_last[part] for part in get_close_matches(last, by_last, n=2)]
    nearest = ", ".join(list(dict.fromkeys(similar))[:3])
    hint = f"Similar names are {nearest}." if nearest else "No name is similar."
    raise ScenarioError(
        f"There is no parameter {name}. {hint} `flybench sweep --parameters` lists all parameters."
    )


def converted(name: str, value: Any) -> Any:
    """Return a value from TOML, converted to the type of the parameter `name`.

    Raises:
        ScenarioError: the value has another type, or is not one of the allowed words.
    """
    kind = parameter_types()[name]
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError:
        raise ScenarioError(
            f"{name} is {value!r}. Allowed is {allowed(kind)}. Correct the value."
        ) from None


def allowed(kind: Any) -> str:
    """Describe the allowed values of a type in words; ranges are checked elsewhere."""
    if get_origin(kind) is Literal:
        return "one of " + ", ".join(f'"{value}"' for value in get_args(kind))
    if get_origin(kind) is tuple:
        return "a list of whole numbers"
    if issubclass(kind, StrEnum):
        members = (member for member in kind if member is not Direction.NONE)  # nothing would move
        return "one of " + ", ".join(f'"{member}"' for member in members)
    return _WORDS[kind]


_WORDS: dict[type, str] = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "text in quotes",
}


def make_config(settings: Settings, base: BaseSensor | None = None) -> RunConfig:
    """Return the run with these values, and defaults for all other parameters.

    Args:
        settings: values, of the parameters' types. "sensor.preset" gives the defaults of the
            sensor, and "method" those of the fly.
        base: sensor of the command line; None: the default of "sensor.preset".

    Raises:
        ScenarioError: a value is out of range or conflicts with another. The message names the
            parameter by its dotted name.
    """
    if base is not None and PRESET in settings:
        raise ScenarioError(
            f"{PRESET} is {settings[PRESET]!r}, and a sensor is given on the command line. Allowed "
            "is one of them. Leave the other out."
        )
    method = settings.get(METHOD, FLY)
    base = base or _base_of(settings.get(PRESET, _DAVIS346))
    check_frames(base.preset, method)
    fly = None
    if any(name.startswith("fly.") for name in settings):
        config = DETECTORS[method].config if is_fly(method) else FlyConfig()
        fly = changed(config, "fly", settings)
    return RunConfig(
        crossing=changed(CrossingConfig(), "crossing", settings),
        sensor=changed(base.config, "sensor", settings),
        method=method,
        fly=fly,
        seed=settings.get(SEED, 0),
    )


def _base_of(name: PresetName) -> BaseSensor:
    return BaseSensor(preset(name), name)


def changed(base: C, section: str, settings: Settings) -> C:
    """Return a section of the configuration, with its subsections, with changed values."""
    changes: dict[str, Any] = {}
    for field in fields(base):  # type: ignore[arg-type]
        name, value = f"{section}.{field.name}", getattr(base, field.name)
        if is_dataclass(value):
            changes[field.name] = changed(value, name, settings)
        elif name in settings:
            changes[field.name] = settings[name]
    try:
        return replace(base, **changes)  # type: ignore[type-var]
    except FlybenchError as error:
        starts_with_field = str(error).split(" ")[0] in {f.name for f in fields(base)}  # type: ignore[arg-type]
        joint = "." if starts_with_field else ": "
        raise ScenarioError(f"{section}{joint}{error}") from error
