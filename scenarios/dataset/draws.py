"""What the parameters of a dataset's sequences are drawn from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from flybench.checks import Range
from scenarios.dataset.scenes.model_take import ARGUMENTS, MODEL, model_value
from scenarios.errors import ScenarioError
from scenarios.sweep.parameters import PRESET, Settings, converted
from scenarios.sweep.random_sample import CHOICE, Distribution, parse_distribution
from scenarios.sweep.sweep_file import flat_parameters

SENSOR_FILE = "sensor.file"
CROSSING, SENSOR = "crossing", "sensor"
SPEED, OMEGA = "crossing.speed_km_h", "crossing.omega_rad_s"
_FOCAL_LENGTH = "sensor.focal_length_mm"
_ALTERNATIVES = (frozenset({PRESET, SENSOR_FILE}), frozenset({SPEED, OMEGA}))
"""Parameters of which only one may be set; one of them in a variant replaces the other."""
_SPEED_KM_H = Range(0.5, 500.0, "km/h")
"""Speeds of vehicles; the bounds of the angular velocity hold, too (assumed)."""


@dataclass(frozen=True)
class Draws:
    """Parameters of the sequences.

    Attributes:
        fixed: values that are the same in every sequence, by the name of the parameter.
        drawn: distributions of the others.
    """

    fixed: Settings = field(default_factory=dict)
    drawn: tuple[Distribution, ...] = ()

    @property
    def names(self) -> frozenset[str]:
        """Names of all parameters."""
        return frozenset(self.fixed).union(d.name for d in self.drawn)

    def with_changes(self, changes: Draws) -> Draws:
        """Return these parameters, with others in their place or added."""
        replaced = changes.names.union(*(a for a in _ALTERNATIVES if changes.names & a))
        kept = {name: value for name, value in self.fixed.items() if name not in replaced}
        drawn = tuple(d for d in self.drawn if d.name not in replaced)
        return Draws(kept | dict(changes.fixed), drawn + changes.drawn)


def parse_draws(tables: Mapping[str, Any]) -> Draws:
    """Return the parameters in the tables `crossing`, `model` and `sensor`.

    Raises:
        ScenarioError: an unknown parameter, a value of a wrong type, or an empty range.
    """
    fixed: dict[str, Any] = {}
    drawn = []
    for name, entry in _parameters(tables):
        if isinstance(entry, dict):
            drawn.append(_distribution(name, entry))
        else:
            fixed[name] = _converted(name, entry)
    draws = Draws(fixed, tuple(drawn))
    for names in _ALTERNATIVES:
        if draws.names >= names:
            raise ScenarioError(
                f"{' and '.join(sorted(names))} are both set. Allowed is one of them. Remove the "
                "other."
            )
    return draws


def _parameters(tables: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    yield from _model_parameters(table_of(tables, MODEL))
    for table, own in ((CROSSING, SPEED), (SENSOR, SENSOR_FILE)):
        entries = dict(table_of(tables, table))
        key = own.partition(".")[2]
        if key in entries:
            yield own, entries.pop(key)
        seen: set[str] = set()
        for name, entry in flat_parameters(entries, f"{table}."):
            if name in seen:
                raise ScenarioError(f"{name} is set twice. Allowed is once. Remove one of them.")
            seen.add(name)
            yield name, entry


def _model_parameters(entries: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for key, entry in entries.items():
        if f"{MODEL}.{key}." == ARGUMENTS:
            for name, value in table_of(entries, key, ARGUMENTS[:-1]).items():
                yield ARGUMENTS + name, value
        else:
            yield f"{MODEL}.{key}", entry


def _converted(name: str, value: Any) -> Any:
    if name == SENSOR_FILE:
        return _file_name(name, value)
    if name == SPEED:
        return _SPEED_KM_H.check(name, value, ScenarioError)
    if name.startswith(f"{MODEL}."):
        return model_value(name, value)
    return converted(name, value)


def _distribution(name: str, entry: Mapping[str, Any]) -> Distribution:
    if name != SENSOR_FILE:
        return parse_distribution(name, entry, f"[{name.split('.')[0]}]", _converted)
    names = entry.get(CHOICE)
    if set(entry) != {CHOICE} or not isinstance(names, list) or not names:
        raise ScenarioError(
            f"{name} is {entry!r}. Allowed is the name of a TOML file, or {{choice = [one, "
            "another]}. List the files to choose from."
        )
    return Distribution(name, CHOICE, tuple(_file_name(name, value) for value in names))


def _file_name(key: str, value: Any) -> str:
    if not isinstance(value, str) or not value:
        raise ScenarioError(
            f"{key} is {value!r}. Allowed is the name of a TOML file in quotes. Correct the name."
        )
    return value


def values_of(name: str, base: Draws, variants: Mapping[str, Draws]) -> list[Any]:
    """Return every value that a parameter can have in the file."""
    found: list[Any] = []
    for draws in (base, *variants.values()):
        found += [draws.fixed[name]] if name in draws.fixed else []
        found += [value for d in draws.drawn if d.name == name for value in d.values]
    return list(dict.fromkeys(found))


def has_model(base: Draws, variants: Mapping[str, Draws]) -> bool:
    """Return True if the scene is a model, not a street."""
    names = base.names.union(*(draws.names for draws in variants.values()))
    return any(name.startswith(f"{MODEL}.") for name in names)


def check_model(base: Draws, variants: Mapping[str, Draws]) -> None:
    """Check that nothing is set that only a street has, or that the model itself states.

    Raises:
        ScenarioError: something is.
    """
    names = base.names.union(*(draws.names for draws in variants.values()))
    for name in sorted(names):
        if name.startswith(f"{CROSSING}."):
            raise ScenarioError(
                f"{name} is set, and [{MODEL}] names a model in place of the street. Allowed is "
                f"one of [{MODEL}] and [{CROSSING}]. Remove the other."
            )
        if name == _FOCAL_LENGTH:
            raise ScenarioError(
                f"{name} is set, and the field of view is that of the model's camera. Allowed are "
                "other parameters of the sensor. Remove it, or set fovy on the camera."
            )


def table_of(tables: Mapping[str, Any], name: str, shown: str | None = None) -> Mapping[str, Any]:
    """Return a table of the file; empty if it is missing.

    Args:
        tables: the tables of the file.
        name: key of the table.
        shown: its whole name, for messages; None: the key.

    Raises:
        ScenarioError: the name stands for something else.
    """
    value = tables.get(name, {})
    if not isinstance(value, dict):
        shown = shown or name
        raise ScenarioError(f"{shown} is {value!r}. Allowed is a table. Write [{shown}] above it.")
    return value
