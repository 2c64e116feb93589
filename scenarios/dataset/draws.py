"""What the parameters of a dataset's sequences are drawn from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from scenarios.errors import ScenarioError
from scenarios.sweep.parameters import PRESET, Settings, converted
from scenarios.sweep.random_sample import CHOICE, Distribution, parse_distribution
from scenarios.sweep.sweep_file import flat_parameters

SENSOR_FILE = "sensor.file"
CROSSING, SENSOR = "crossing", "sensor"
_SOURCES = frozenset({PRESET, SENSOR_FILE})


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
        replaced = changes.names | (_SOURCES if changes.names & _SOURCES else frozenset())
        kept = {name: value for name, value in self.fixed.items() if name not in replaced}
        drawn = tuple(d for d in self.drawn if d.name not in replaced)
        return Draws(kept | dict(changes.fixed), drawn + changes.drawn)


def parse_draws(tables: Mapping[str, Any]) -> Draws:
    """Return the parameters in the tables `crossing` and `sensor`.

    Raises:
        ScenarioError: an unknown parameter, a value of a wrong type, or an empty range.
    """
    fixed: dict[str, Any] = {}
    drawn = []
    for name, entry in _parameters(tables):
        if isinstance(entry, dict):
            drawn.append(_distribution(name, entry))
        else:
            fixed[name] = _file_name(name, entry) if name == SENSOR_FILE else converted(name, entry)
    both = fixed.keys() | {d.name for d in drawn}
    if both >= _SOURCES:
        raise ScenarioError(
            f"{PRESET} and {SENSOR_FILE} are both set. Allowed is one of them. Remove the other."
        )
    return Draws(fixed, tuple(drawn))


def _parameters(tables: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for table in (CROSSING, SENSOR):
        entries = dict(table_of(tables, table))
        if table == SENSOR and "file" in entries:
            yield SENSOR_FILE, entries.pop("file")
        seen: set[str] = set()
        for name, entry in flat_parameters(entries, f"{table}."):
            if name in seen:
                raise ScenarioError(f"{name} is set twice. Allowed is once. Remove one of them.")
            seen.add(name)
            yield name, entry


def _distribution(name: str, entry: Mapping[str, Any]) -> Distribution:
    if name != SENSOR_FILE:
        return parse_distribution(name, entry, f"[{name.split('.')[0]}]")
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


def table_of(tables: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Return a table of the file; empty if it is missing.

    Raises:
        ScenarioError: the name stands for something else.
    """
    value = tables.get(name, {})
    if not isinstance(value, dict):
        raise ScenarioError(f"{name} is {value!r}. Allowed is a table. Write [{name}] above it.")
    return value
