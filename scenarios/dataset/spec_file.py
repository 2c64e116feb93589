"""Read and check the TOML file that describes a dataset."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from emulator import SensorConfig
from emulator.presets import WITHOUT_FRAMES
from flybench.checks import Range
from flybench.errors import FlybenchError
from scenarios.dataset.draws import (
    CROSSING,
    SENSOR,
    SENSOR_FILE,
    Draws,
    check_model,
    has_model,
    parse_draws,
    table_of,
    values_of,
)
from scenarios.dataset.labels.kinds import (
    BY_DEFAULT,
    Label,
    check_frames,
    check_target,
    parse_labels,
)
from scenarios.dataset.scenes.model_take import MODEL
from scenarios.dataset.splits import check_name as check_split_name
from scenarios.errors import ScenarioError
from scenarios.options.sensor import sensor_of
from scenarios.options.toml_file import read_toml
from scenarios.sweep.parameters import PRESET

_TITLE, _LICENSE, _SEED, _SPLITS, _LABELS = "title", "license", "seed", "splits", "labels"
_VARIANTS, _DISJOINT, _WANTED, _PERIOD = "variants", "disjoint", "wanted", "period_ms"
_TOP = (_TITLE, _LICENSE, _SEED, _SPLITS, _LABELS, SENSOR, CROSSING, MODEL, _VARIANTS)
DEFAULT_PERIOD_MS = 50
"""Default time between labels [ms]: that of DSEC's images."""
_PERIOD_MS = Range(1, 10_000, "ms")
_SEEDS = Range(0, 2**32 - 1)
MAX_SEQUENCES = 1_000_000
"""Greatest number of sequences (assumed; at 10 s each they take four months on one core)."""
_COUNT = Range(1, MAX_SEQUENCES)


class DatasetSpecError(ScenarioError):
    """A file that describes a dataset cannot be read, or its contents are invalid."""


@dataclass(frozen=True)
class DatasetSpec:
    """Contents of the file.

    Attributes:
        path: path of the file.
        text: text of the file.
        title: title of the dataset.
        license: its licence, such as "CC-BY-4.0".
        seed: seed of everything that is drawn.
        counts: number of sequences of each split, by name.
        disjoint: parameters whose values in one split appear in no other.
        labels: labels to write.
        period_us: time between labels [µs].
        base: parameters of all sequences.
        variants: names of the variants, and what differs in each; sequences take them in turn.
        sensors: sensors that the file reads from TOML files, by their names in the file.
    """

    path: Path
    text: str
    title: str
    license: str
    seed: int
    counts: Mapping[str, int]
    disjoint: tuple[str, ...]
    labels: tuple[Label, ...]
    period_us: int
    base: Draws
    variants: Mapping[str, Draws]
    sensors: Mapping[str, SensorConfig]

    @property
    def is_model(self) -> bool:
        """True if the scene is a model, not a street."""
        return has_model(self.base, self.variants)


def read_spec(path: Path) -> DatasetSpec:
    """Read the file.

    Raises:
        DatasetSpecError: the file does not exist, is not TOML, or holds an unknown key or a value
            of a wrong type. The message names the file, the key, the value and what is allowed.
    """
    text, tables = read_toml(path, DatasetSpecError)
    try:
        return _parse(path, text, tables)
    except FlybenchError as error:
        raise DatasetSpecError(f"{path}: {error}") from error


def _parse(path: Path, text: str, tables: dict[str, Any]) -> DatasetSpec:
    _check_keys(tables, _TOP, "")
    splits, labels = table_of(tables, _SPLITS), table_of(tables, _LABELS)
    _check_keys(labels, (_WANTED, _PERIOD), f"{_LABELS}.")
    base, variants = parse_draws(tables), _variants(tables)
    if has_model(base, variants):
        check_model(base, variants)
    sensors = {name: _read_sensor(path, name) for name in _sensor_files(base, variants)}
    return DatasetSpec(
        path=path,
        text=text,
        title=_text(tables, _TITLE, '"Street crossings"'),
        license=_text(tables, _LICENSE, '"CC-BY-4.0"'),
        seed=_SEEDS.check(_SEED, tables.get(_SEED, 0), ScenarioError),
        counts=_counts(splits),
        disjoint=_disjoint(splits.get(_DISJOINT, [])),
        labels=_labels(
            labels, _frameless(path, base, variants), is_model=has_model(base, variants)
        ),
        period_us=1000
        * _PERIOD_MS.check(
            f"{_LABELS}.{_PERIOD}", labels.get(_PERIOD, DEFAULT_PERIOD_MS), ScenarioError
        ),
        base=base,
        variants=variants,
        sensors=sensors,
    )


def _check_keys(table: Mapping[str, Any], allowed: tuple[str, ...], prefix: str) -> None:
    for key in table:
        if key not in allowed:
            near = get_close_matches(key, allowed, n=1)
            hint = f"Did you mean {near[0]}?" if near else "Correct the name or leave it out."
            raise ScenarioError(
                f"There is no key {prefix}{key}. Allowed is {', '.join(allowed)}. {hint}"
            )


def _text(tables: Mapping[str, Any], key: str, example: str) -> str:
    value = tables.get(key)
    if not isinstance(value, str) or not value.strip() or "\n" in value:
        raise ScenarioError(
            f"{key} is {value!r}. Allowed is one line of text in quotes. Write, for example, "
            f"{key} = {example} at the top of the file."
        )
    return value.strip()


def _counts(splits: Mapping[str, Any]) -> dict[str, int]:
    counts = {name: value for name, value in splits.items() if name != _DISJOINT}
    if not counts:
        raise ScenarioError(
            f"[{_SPLITS}] names no split. Allowed is one split or more, with its number of "
            "sequences. Write, for example, train = 100."
        )
    for name, value in counts.items():
        check_split_name(f"{_SPLITS}.{name}", name)
        _COUNT.check(f"{_SPLITS}.{name}", value, ScenarioError)
    if sum(counts.values()) > MAX_SEQUENCES:
        raise ScenarioError(
            f"[{_SPLITS}] has {sum(counts.values()):,} sequences in all. Allowed are "
            f"{MAX_SEQUENCES:,}. Choose smaller numbers."
        )
    return counts


def _disjoint(value: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        raise ScenarioError(
            f"{_SPLITS}.{_DISJOINT} is {value!r}. Allowed is a list of parameters that are drawn. "
            f'Write, for example, {_DISJOINT} = ["crossing.street_seed"].'
        )
    return tuple(dict.fromkeys(value))


def _labels(table: Mapping[str, Any], frameless: list[str], *, is_model: bool) -> tuple[Label, ...]:
    """Return the labels of the file; by default those that every sensor and scene can give."""
    key = f"{_LABELS}.{_WANTED}"
    if _WANTED not in table:
        missing = {Label.APS} if frameless else set()
        missing |= {Label.MOTION} if is_model else set()
        return tuple(label for label in BY_DEFAULT if label not in missing)
    labels = parse_labels(key, table[_WANTED])
    check_frames(key, labels, frameless)
    if is_model:
        check_target(key, labels)
    return labels


def _frameless(spec: Path, base: Draws, variants: Mapping[str, Draws]) -> list[str]:
    """Return the presets and files of sensors whose chips record no frames."""
    presets = {name: name for name in values_of(PRESET, base, variants)}
    for name in _sensor_files(base, variants):
        presets[name] = read_toml(spec.parent / name, ScenarioError)[1].get("preset")
    return [name for name, chip in presets.items() if chip in WITHOUT_FRAMES]


def _variants(tables: Mapping[str, Any]) -> dict[str, Draws]:
    entries = tables.get(_VARIANTS, [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise ScenarioError(
            f"{_VARIANTS} is {entries!r}. Allowed is one table per variant. Write [[{_VARIANTS}]] "
            "above each of them."
        )
    variants: dict[str, Draws] = {}
    for entry in entries:
        _check_keys(entry, ("name", CROSSING, MODEL, SENSOR), f"{_VARIANTS}.")
        name = entry.get("name")
        if not isinstance(name, str) or not name or name in variants:
            raise ScenarioError(
                f"{_VARIANTS}.name is {name!r}. Allowed is text in quotes, each name once. Write, "
                f'for example, name = "night" in each [[{_VARIANTS}]].'
            )
        variants[name] = parse_draws(entry)
    return variants


def _sensor_files(base: Draws, variants: Mapping[str, Draws]) -> list[str]:
    return list(values_of(SENSOR_FILE, base, variants))


def _read_sensor(spec: Path, name: str) -> SensorConfig:
    """Return the sensor of a TOML file; a relative name starts from the folder of the spec."""
    path = spec.parent / name
    try:
        return sensor_of(read_toml(path, ScenarioError)[1])
    except FlybenchError as error:
        raise ScenarioError(f"{SENSOR_FILE} is {name!r}: {error}") from error
