"""Read and check the TOML file of a sweep."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from scenarios.errors import ScenarioError
from scenarios.options.toml_file import read_toml
from scenarios.sweep.parameters import (
    METHOD,
    PRESET,
    SEED,
    Settings,
    check_name,
    converted,
    sections,
)
from scenarios.sweep.random_sample import RandomSample, parse_distribution

SEEDS, FIXED, GRID, LEVELS, SAMPLE = "seeds", "fixed", "grid", "levels", "sample"
_TOP = (SEEDS, FIXED, GRID, LEVELS, SAMPLE)
COUNT, NAME = "count", "name"
MAX_POINTS = 100_000
"""Greatest number of points; even the cheapest would take more than a day (assumed)."""


class SweepFileError(ScenarioError):
    """A sweep file cannot be read, or its contents are invalid."""


@dataclass(frozen=True)
class Level:
    """One level of an axis.

    Attributes:
        settings: values of parameters, by name.
        labels: further columns of the table, such as {"clutter": "calm"}.
    """

    settings: Settings
    labels: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class SweepFile:
    """Contents of a sweep file.

    Attributes:
        path: path of the file.
        text: text of the file.
        fixed: values that all points share.
        axes: levels of each axis, in the order of the file.
        sample: random sample; None if nothing is drawn at random.
        seeds: seeds of the sensors; empty if the settings give the seed.
    """

    path: Path
    text: str
    fixed: Settings
    axes: tuple[tuple[Level, ...], ...]
    sample: RandomSample | None
    seeds: tuple[int, ...]


def read_sweep(path: Path) -> SweepFile:
    """Read a sweep file.

    Raises:
        SweepFileError: the file does not exist, is not TOML, or holds an unknown key or a value of
            a wrong type. The message names the file, the key, the value and what is allowed.
    """
    text, tables = read_toml(path, SweepFileError)
    try:
        return _parse(path, text, tables)
    except ScenarioError as error:
        raise SweepFileError(f"{path}: {error}") from error


def _parse(path: Path, text: str, tables: dict[str, Any]) -> SweepFile:
    for name, value in tables.items():
        _check_table(name, value)
    given: dict[str, str] = {}
    fixed = {k: converted(k, v) for k, v in _parameters(FIXED, tables, given)}
    axes = []
    for name in tables:
        if name == GRID:
            axes += [_grid_axis(k, v) for k, v in _parameters(GRID, tables, given)]
        elif name == LEVELS:
            axes += [_named_axis(k, v, given) for k, v in tables[LEVELS].items()]
    sample = _sample(tables, given) if SAMPLE in tables else None
    seeds = _seeds(tables[SEEDS], given) if SEEDS in tables else ()
    if not (axes or sample or seeds):
        raise ScenarioError(
            "Nothing varies in this file. Allowed is a file with [grid], [[levels.NAME]], [sample] "
            "or seeds. Add at least one of them."
        )
    return SweepFile(path, text, fixed, tuple(axes), sample, seeds)


def _check_table(name: str, value: Any) -> None:
    if name not in _TOP:
        similar = get_close_matches(name, _TOP, n=1)
        hint = f"Did you mean {similar[0]}?" if similar else f"Put it into [{FIXED}] or [{GRID}]."
        raise ScenarioError(
            f"{name} is not a key of a sweep. Allowed at the top level is {', '.join(_TOP)}. {hint}"
        )
    if name != SEEDS and not isinstance(value, dict):
        raise ScenarioError(f"{name} is {value!r}. Allowed is a table. Write [{name}] above it.")


def _parameters(
    table: str, tables: Mapping[str, Any], given: dict[str, str]
) -> Iterator[tuple[str, Any]]:
    """Yield every parameter of a table by its dotted name, however the dots are written."""
    for name, value in flat_parameters(tables.get(table, {}), ""):
        _claim(name, f"[{table}]", given)
        yield name, value


def flat_parameters(values: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    """Yield the entries of nested tables by the dotted names of their parameters.

    Raises:
        ScenarioError: there is no parameter of a name.
    """
    for key, value in values.items():
        name = prefix + key
        if isinstance(value, dict) and name in sections():
            yield from flat_parameters(value, f"{name}.")
        else:
            check_name(name)
            yield name, value


def _claim(name: str, place: str, given: dict[str, str]) -> None:
    if name in given:
        both = place if given[name] == place else f"{given[name]} and in {place}"
        raise ScenarioError(f"{name} is set twice, in {both}. Allowed is once. Remove one of them.")
    given[name] = place


def _grid_axis(name: str, values: Any) -> tuple[Level, ...]:
    if not isinstance(values, list) or not values:
        raise ScenarioError(
            f"{name} is {values!r}. Allowed in [{GRID}] is a list of one or more values. For a "
            f"single value use [{FIXED}]."
        )
    typed = [converted(name, value) for value in values]
    seen: set[Any] = set()
    for given, value in zip(values, typed, strict=True):
        if value in seen:
            raise ScenarioError(
                f"{name} holds {given!r} twice. Allowed is every value once. To repeat a point "
                f"with other noise, use {SEEDS}."
            )
        seen.add(value)
    return tuple(Level({name: value}) for value in typed)


def _named_axis(axis: str, entries: Any, given: dict[str, str]) -> tuple[Level, ...]:
    known = {METHOD, SEED, PRESET, NAME} | sections()
    if axis in known or "." in axis:
        raise ScenarioError(
            f"{LEVELS}.{axis} is not a valid name for an axis. Allowed is any name without a dot "
            f"except {', '.join(sorted(k for k in known if '.' not in k))}. Choose another name."
        )
    if not (isinstance(entries, list) and entries and all(isinstance(e, dict) for e in entries)):
        raise ScenarioError(
            f"{LEVELS}.{axis} is {entries!r}. Allowed is one table per level. Write "
            f"[[{LEVELS}.{axis}]] above each level."
        )
    levels = [_named_level(axis, dict(entry)) for entry in entries]
    names = [level.labels[axis] for level in levels]
    if len(set(names)) < len(names):
        raise ScenarioError(
            f"The names of {LEVELS}.{axis} are {', '.join(names)}. Allowed is each name once. "
            "Rename one level."
        )
    for name in dict.fromkeys(name for level in levels for name in level.settings):
        _claim(name, f"[[{LEVELS}.{axis}]]", given)
    return tuple(levels)


def _named_level(axis: str, entry: dict[str, Any]) -> Level:
    name = entry.pop(NAME, None)
    if not isinstance(name, str) or not name:
        raise ScenarioError(
            f"{LEVELS}.{axis}.{NAME} is {name!r}. Allowed is text in quotes, which labels the rows "
            f'of the table. Write, for example, {NAME} = "calm" in each [[{LEVELS}.{axis}]].'
        )
    settings: dict[str, Any] = {}
    for parameter, value in flat_parameters(entry, ""):
        if parameter in settings:
            raise ScenarioError(
                f"{parameter} is set twice, in {LEVELS}.{axis} {name}. Allowed is once. Remove one "
                "of them."
            )
        settings[parameter] = converted(parameter, value)
    return Level(settings, {axis: name})


def _sample(tables: Mapping[str, Any], given: dict[str, str]) -> RandomSample:
    table = dict(tables[SAMPLE])
    count, seed = table.pop(COUNT, None), table.pop(SEED, 0)
    for name, value, least in ((COUNT, count, 1), (SEED, seed, 0)):
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value < 2**32:
            raise ScenarioError(
                f"{SAMPLE}.{name} is {value!r}. Allowed is a whole number from {least} to "
                f"{2**32 - 1}. Write, for example, {name} = 100 in [{SAMPLE}]."
            )
    entries = _parameters(SAMPLE, {SAMPLE: table}, given)
    distributions = tuple(parse_distribution(name, entry) for name, entry in entries)
    if not distributions:
        raise ScenarioError(
            f"[{SAMPLE}] holds no parameter. Allowed is one parameter or more. Add, for example, "
            "crossing.omega_rad_s = {uniform = [0.5, 2.5]}."
        )
    return RandomSample(distributions, count, seed)


def _seeds(value: Any, given: dict[str, str]) -> tuple[int, ...]:
    _claim(SEED, SEEDS, given)
    is_count = type(value) is int and 1 <= value <= MAX_POINTS
    seeds = list(range(value)) if is_count else value
    if not isinstance(seeds, list) or not seeds:
        raise ScenarioError(
            f"{SEEDS} is {value!r}. Allowed is a number of seeds from 1 to {MAX_POINTS:,}, or a "
            f"list of seeds. Write, for example, {SEEDS} = 5."
        )
    typed = tuple(converted(SEED, seed) for seed in seeds)
    if len(set(typed)) < len(typed):
        raise ScenarioError(
            f"{SEEDS} is {value!r}. Allowed is every seed once. Remove the duplicates."
        )
    return typed
