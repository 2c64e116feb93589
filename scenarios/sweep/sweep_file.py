"""What a sweep's TOML file says, checked as it is read."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from scenarios.errors import ScenarioError
from scenarios.sweep.draws import Sample, parse_draw
from scenarios.sweep.parameters import (
    METHOD,
    PRESET,
    SEED,
    Settings,
    check_name,
    converted,
    sections,
)

SEEDS, FIXED, GRID, LEVELS, SAMPLE = "seeds", "fixed", "grid", "levels", "sample"
_TOP = (SEEDS, FIXED, GRID, LEVELS, SAMPLE)
COUNT, NAME = "count", "name"
MOST_POINTS = 100_000
"""A day or more even of the cheapest (assumed)."""


class SweepFileError(ScenarioError):
    """A sweep's file that cannot be read, or says what cannot be."""


@dataclass(frozen=True)
class Level:
    """One level of an axis.

    Attributes:
        settings: values of parameters.
        labels: what the table says besides, such as {"clutter": "calm"}.
    """

    settings: Settings
    labels: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class SweepFile:
    """What to run.

    Attributes:
        path: where it was read from.
        text: as it stands there.
        fixed: values that all points share.
        axes: levels of each, in the order of the file.
        sample: what is drawn at random; None: nothing.
        seeds: of the sensors; empty: the one of the settings.
    """

    path: Path
    text: str
    fixed: Settings
    axes: tuple[tuple[Level, ...], ...]
    sample: Sample | None
    seeds: tuple[int, ...]


def read_sweep(path: Path) -> SweepFile:
    """Read a sweep's file.

    Raises:
        SweepFileError: it is not there, no TOML, or holds an unknown key or a value of a wrong
            type; the message names file, key, value and what is allowed.
    """
    text = _read(path)
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SweepFileError(
            f"{path} is no TOML: {error}; allowed is what toml.io describes, every key once; mend "
            "that place"
        ) from None
    try:
        return _parse(path, text, tables)
    except ScenarioError as error:
        raise SweepFileError(f"{path}: {error}") from error


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise SweepFileError(
            f"{path} is no text; allowed is a TOML file in UTF-8; give another"
        ) from None
    except OSError as error:
        raise SweepFileError(
            f"{path} cannot be read ({error.strerror}); allowed is a TOML file; give another"
        ) from error


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
            "nothing varies; allowed is a file with [grid], [[levels.NAME]], [sample] or seeds; "
            "give at least one of them"
        )
    return SweepFile(path, text, fixed, tuple(axes), sample, seeds)


def _check_table(name: str, value: Any) -> None:
    if name not in _TOP:
        near = get_close_matches(name, _TOP, n=1)
        hint = f"near it is {near[0]}" if near else f"parameters stand in [{FIXED}] or [{GRID}]"
        raise ScenarioError(
            f"{name} is no key of a sweep; allowed at the top is {', '.join(_TOP)}; {hint}"
        )
    if name != SEEDS and not isinstance(value, dict):
        raise ScenarioError(f"{name} is {value!r}; allowed is a table; write [{name}] above it")


def _parameters(
    table: str, tables: Mapping[str, Any], given: dict[str, str]
) -> Iterator[tuple[str, Any]]:
    """Every parameter of a table by its dotted name, however the dots are written."""
    for name, value in _flat(tables.get(table, {}), ""):
        _claim(name, f"[{table}]", given)
        yield name, value


def _flat(values: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        name = prefix + key
        if isinstance(value, dict) and name in sections():
            yield from _flat(value, f"{name}.")
        else:
            check_name(name)
            yield name, value


def _claim(name: str, place: str, given: dict[str, str]) -> None:
    if name in given:
        both = place if given[name] == place else f"{given[name]} and in {place}"
        raise ScenarioError(f"{name} is set twice, in {both}; allowed is once; leave one out")
    given[name] = place


def _grid_axis(name: str, values: Any) -> tuple[Level, ...]:
    if not isinstance(values, list) or not values:
        raise ScenarioError(
            f"{name} is {values!r}; allowed in [{GRID}] is a list of one or more values; for a "
            f"single one use [{FIXED}]"
        )
    typed = [converted(name, value) for value in values]
    for n, value in enumerate(typed):
        if value in typed[:n]:
            raise ScenarioError(
                f"{name} holds {values[n]!r} twice; allowed is every value once; for several "
                f"drawings of the noise use {SEEDS}"
            )
    return tuple(Level({name: value}) for value in typed)


def _named_axis(axis: str, entries: Any, given: dict[str, str]) -> tuple[Level, ...]:
    known = {METHOD, SEED, PRESET, NAME} | sections()
    if axis in known or "." in axis:
        raise ScenarioError(
            f"{LEVELS}.{axis} is no name for an axis; allowed is any without a dot but "
            f"{', '.join(sorted(k for k in known if '.' not in k))}; choose another"
        )
    if not (isinstance(entries, list) and entries and all(isinstance(e, dict) for e in entries)):
        raise ScenarioError(
            f"{LEVELS}.{axis} is {entries!r}; allowed are tables, one a level; write "
            f"[[{LEVELS}.{axis}]] above each"
        )
    levels = [_named_level(axis, dict(entry)) for entry in entries]
    names = [level.labels[axis] for level in levels]
    if len(set(names)) < len(names):
        raise ScenarioError(
            f"the names of {LEVELS}.{axis} are {', '.join(names)}; allowed is each name once; "
            "rename one"
        )
    for name in dict.fromkeys(name for level in levels for name in level.settings):
        _claim(name, f"[[{LEVELS}.{axis}]]", given)
    return tuple(levels)


def _named_level(axis: str, entry: dict[str, Any]) -> Level:
    name = entry.pop(NAME, None)
    if not isinstance(name, str) or not name:
        raise ScenarioError(
            f"{LEVELS}.{axis}.{NAME} is {name!r}; allowed is text in quotes, which stands in the "
            f'table; write {NAME} = "calm", say, in each [[{LEVELS}.{axis}]]'
        )
    settings: dict[str, Any] = {}
    for parameter, value in _flat(entry, ""):
        if parameter in settings:
            raise ScenarioError(
                f"{parameter} is set twice, in {LEVELS}.{axis} {name}; allowed is once; leave one "
                "out"
            )
        settings[parameter] = converted(parameter, value)
    return Level(settings, {axis: name})


def _sample(tables: Mapping[str, Any], given: dict[str, str]) -> Sample:
    table = dict(tables[SAMPLE])
    count, seed = table.pop(COUNT, None), table.pop(SEED, 0)
    for name, value, least in ((COUNT, count, 1), (SEED, seed, 0)):
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value < 2**32:
            raise ScenarioError(
                f"{SAMPLE}.{name} is {value!r}; allowed is a whole number from {least} on; write "
                f"{name} = 100, say, in [{SAMPLE}]"
            )
    laws = _parameters(SAMPLE, {SAMPLE: table}, given)
    draws = tuple(parse_draw(name, law) for name, law in laws)
    if not draws:
        raise ScenarioError(
            f"[{SAMPLE}] draws nothing; allowed is one parameter or more; add one, such as "
            "crossing.omega_rad_s = {uniform = [0.5, 2.5]}"
        )
    return Sample(draws, count, seed)


def _seeds(value: Any, given: dict[str, str]) -> tuple[int, ...]:
    _claim(SEED, SEEDS, given)
    is_count = type(value) is int and 1 <= value <= MOST_POINTS
    seeds = list(range(value)) if is_count else value
    if not isinstance(seeds, list) or not seeds:
        raise ScenarioError(
            f"{SEEDS} is {value!r}; allowed is how many, from 1 to {MOST_POINTS:,}, or a list of "
            f"seeds; write {SEEDS} = 5, say"
        )
    typed = tuple(converted(SEED, seed) for seed in seeds)
    if len(set(typed)) < len(typed):
        raise ScenarioError(f"{SEEDS} is {value!r}; allowed is every seed once; leave one out")
    return typed
