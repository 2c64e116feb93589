"""Which sensor a command takes: a preset, a TOML file on top of it, single values on top of that.

A file holds what is different about the sensor, by the names of `emulator.SensorConfig`; frames are
in a table `aps`, the readout in a table `readout`, bias currents, coarse and fine, in a table
`biases`:

    preset = "dvs128"
    theta_on = 0.25
    biases = { refractory = [4, 25] }

    [aps]
    shutter = "rolling"

Where `biases` are given, they set thresholds, bandwidths and refractory period together, those of
the maker where not named; plain numbers come on top of them.
"""

from __future__ import annotations

import hashlib
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, get_args

import tyro

from emulator import (
    ApsConfig,
    Bias,
    Biases,
    ReadoutConfig,
    SensorConfig,
    SensorConfigError,
    preset,
    with_biases,
)
from emulator.presets import WITHOUT_FRAMES, PresetName
from scenarios.errors import ScenarioError

DEFAULT: PresetName = "davis346"
_PRESET, _APS, _READOUT, _BIASES = "preset", "aps", "readout", "biases"
_BARE_WORD = re.compile(r"[A-Za-z_]\w*")
_SET_HELP = (
    "What else is different, such as theta_on=0.25 aps.shutter=rolling. One bias, such as "
    "biases.on=[6,200], takes thresholds, bandwidths and refractory period from bias currents, all "
    "of them: those not named are the maker's, not those of the preset"
)
_Groups = Annotated[
    tuple[tuple[str, ...], ...],
    tyro.conf.UseAppendAction,
    tyro.conf.arg(name="set", metavar="NAME=VALUE", help=_SET_HELP),
]


def _joined(groups: _Groups = ()) -> tuple[str, ...]:
    """Values of `--set`, given one after another or with the flag repeated."""
    return tuple(value for group in groups for value in group)


@dataclass(frozen=True)
class SensorOptions:
    """The sensor: a preset, and what is different about it."""

    preset: Annotated[PresetName | None, tyro.conf.arg(metavar="|".join(get_args(PresetName)))] = (
        None
    )
    """Which sensor; davis346 where not given."""
    config: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """TOML file of what is different: theta_on = 0.25, tables [aps], [readout] and [biases]."""
    set: Annotated[tuple[str, ...], tyro.conf.arg(name="", constructor=_joined)] = ()
    """What else is different: NAME=VALUE, each name once."""

    def changes(self) -> dict[str, Any]:
        """What the arguments ask for, as the file would hold it, preset included.

        Raises:
            ScenarioError: the file cannot be read, an argument is no NAME=VALUE, or a name is
                given twice.
        """
        merged: dict[str, Any] = {} if self.config is None else _read(self.config)
        given = [_parsed(argument) for argument in self.set]
        _check_once([name for name, _ in given])
        for name, value in given:
            *tables, key = name.split(".")
            place = merged
            for table in tables:
                place = place.setdefault(table, {})
                if not isinstance(place, dict):
                    raise _no_such(name, table, SensorConfig)
            place[key] = value
        chosen = self.preset or merged.pop(_PRESET, DEFAULT)
        return {**merged, _PRESET: chosen}

    def sensor(self) -> SensorConfig:
        """The sensor that the arguments ask for.

        Raises:
            ScenarioError: as `changes` does, or a name that a sensor does not have.
            SensorConfigError: a value is outside its range, or the preset unknown.
        """
        return sensor_of(self.changes())

    @property
    def frames(self) -> bool:
        """Whether the preset's chip has frames."""
        return str(self.changes()[_PRESET]) not in WITHOUT_FRAMES

    @property
    def name(self) -> str:
        """The preset, and a digest of what is different, to name a folder by."""
        changes = self.changes()
        base = str(changes.pop(_PRESET))
        if not changes:
            return base
        return f"{base}_{hashlib.sha256(repr(_sorted(changes)).encode()).hexdigest()[:8]}"


def sensor_of(changes: Mapping[str, Any]) -> SensorConfig:
    """A preset with changes.

    Args:
        changes: values by the names of `SensorConfig`; "preset", "aps", "readout" and "biases" as
            a file has them (see the module).

    Raises:
        ScenarioError: a name that a sensor does not have.
        SensorConfigError: a value is outside its range, or the preset unknown.
    """
    plain = {k: v for k, v in changes.items() if k not in {_PRESET, _APS, _READOUT, _BIASES}}
    _check_names(plain, SensorConfig, "")
    config = preset(changes.get(_PRESET, DEFAULT))
    if _BIASES in changes:
        config = with_biases(config, _biases_of(_table(changes, _BIASES, Biases)))
    parts: dict[str, Any] = {
        _APS: replace(config.aps, **_table(changes, _APS, ApsConfig)),
        _READOUT: replace(config.readout, **_table(changes, _READOUT, ReadoutConfig)),
    }
    return replace(config, **plain, **parts)


def _biases_of(codes: Mapping[str, Any]) -> Biases:
    for name, pair in codes.items():
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            raise ScenarioError(
                f"{_BIASES}.{name} is {pair!r}; allowed is a coarse and a fine code; give them as "
                f"{name} = [5, 255]"
            )
    return Biases(**{name: _bias(name, *pair) for name, pair in codes.items()})


def _bias(name: str, coarse: Any, fine: Any) -> Bias:
    try:
        return Bias(coarse, fine)
    except SensorConfigError as error:
        raise SensorConfigError(f"{_BIASES}.{name}: {error}") from None


def _table(changes: Mapping[str, Any], name: str, kind: type) -> Mapping[str, Any]:
    table = changes.get(name, {})
    if not isinstance(table, Mapping):
        raise ScenarioError(
            f"{name} is {table!r}; allowed is a table of values; give them one by one, such as "
            f"{name}.{fields(kind)[0].name}"
        )
    _check_names(table, kind, f"{name}.")
    return table


def _check_names(values: Iterable[str], kind: type, prefix: str) -> None:
    for name in values:
        if name not in {field.name for field in fields(kind)}:
            raise _no_such(prefix + name, name, kind)


def _no_such(full: str, name: str, kind: type) -> ScenarioError:
    allowed = [field.name for field in fields(kind)]
    if kind is SensorConfig:
        allowed += [_PRESET, _BIASES]
    near = get_close_matches(name, allowed, n=1)
    remedy = f"did you mean {near[0]}?" if near else "correct the name or leave it out"
    return ScenarioError(
        f"a sensor has no {full!r}; allowed here is one of {', '.join(allowed)}; {remedy}"
    )


def _check_once(names: Sequence[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise ScenarioError(
                f"--set has {name} {names.count(name)} times; allowed is each name once; leave "
                "all but one out"
            )


def _parsed(argument: str) -> tuple[str, Any]:
    """Name and value of an argument NAME=VALUE."""
    name, equals, text = (part.strip() for part in argument.partition("="))
    if not (name and equals and text):
        raise ScenarioError(
            f"--set {argument!r} is no NAME=VALUE; allowed is a name and a value of the sensor; "
            "write it as theta_on=0.25, without blanks"
        )
    if _BARE_WORD.fullmatch(text) and text not in {"true", "false", "inf", "nan"}:
        return name, text
    try:
        return name, tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        raise ScenarioError(
            f"--set {argument!r} has a value that cannot be read; allowed is a number, true, "
            "false, a word or [coarse, fine]; write it as theta_on=0.25"
        ) from None


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ScenarioError(
            f"the sensor's file {path} cannot be read ({error.strerror}); allowed is a TOML file; "
            "give its path with --config"
        ) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ScenarioError(
            f"the sensor's file {path} is no TOML: {error}; allowed are lines such as "
            "theta_on = 0.25; mend it"
        ) from error


def _sorted(values: Any) -> Any:
    """Nested tables as nested lists in the order of their names."""
    if isinstance(values, Mapping):
        return [(name, _sorted(values[name])) for name in sorted(values)]
    return values
