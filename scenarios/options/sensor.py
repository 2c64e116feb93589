"""The sensor of a command: a preset or a TOML file, changed by single values.

The file contains the values that differ from its preset, by the names of `emulator.SensorConfig`.
Values of the frames are in a table `aps`, those of the readout in a table `readout`, bias currents
as coarse and fine codes in a table `biases`. `flybench calibrate` writes such a file:

    preset = "dvs128"
    theta_on = 0.25
    biases = { refractory = [4, 25] }

    [aps]
    shutter = "rolling"

If there are `biases`, they set thresholds, bandwidths and refractory period together; biases that
are not named have the manufacturer's values. Plain numbers override what the biases give.
"""

from __future__ import annotations

import hashlib
import re
import shlex
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
from flybench.errors import FlybenchError
from scenarios.errors import ScenarioError
from scenarios.options.toml_file import parse_toml, read_toml

DEFAULT: PresetName = "davis346"
_PRESETS: tuple[str, ...] = get_args(PresetName)
_PRESET, _APS, _READOUT, _BIASES = "preset", "aps", "readout", "biases"
_BARE_WORD = re.compile(r"[A-Za-z_]\w*")
_SENSOR_HELP = (
    "Sensor: the name of a preset, or a TOML file as flybench calibrate writes it. The presets are "
    f"{', '.join(get_args(PresetName))}. A file has the parameters that differ from its preset, "
    "such as theta_on = 0.25, those of frames and readout in tables [aps] and [readout], and bias "
    "currents in a table [biases]."
)
_SET_HELP = (
    "Sensor parameters that differ from those of --sensor, such as theta_on=0.25 "
    "aps.shutter=rolling; each name once. If a bias is set, such as biases.on=[6,200] (coarse and "
    "fine code), thresholds, bandwidths and refractory period are computed from bias currents. "
    "Biases that are not set then have the manufacturer's values, not those of the preset."
)
_Groups = Annotated[
    tuple[tuple[str, ...], ...],
    tyro.conf.UseAppendAction,
    tyro.conf.arg(name="set", metavar="NAME=VALUE", help=_SET_HELP),
]


def _joined(groups: _Groups = ()) -> tuple[str, ...]:
    """Return the values of `--set` in one tuple, whether or not the flag was repeated."""
    return tuple(value for group in groups for value in group)


@dataclass(frozen=True)
class SensorOptions:
    """The sensor: a preset or a file, and the parameters that differ from it."""

    sensor: Annotated[
        str | None,
        tyro.conf.arg(
            metavar="PRESET|FILE",
            help=_SENSOR_HELP,
            help_behavior_hint=f"(default: {DEFAULT})",
        ),
    ] = None
    set: Annotated[tuple[str, ...], tyro.conf.arg(name="", constructor=_joined)] = ()
    """Sensor parameters that differ from those of --sensor, as NAME=VALUE, each name once."""

    def changes(self) -> dict[str, Any]:
        """Return preset and parameters in the form of the TOML file.

        Raises:
            ScenarioError: there is no such preset and no such file, the file cannot be read, an
                argument is not NAME=VALUE, or a name is given twice.
        """
        merged = self._base()
        given = [_parsed(argument) for argument in self.set]
        _check_once([name for name, _ in given])
        for name, value in given:
            *tables, key = name.split(".")
            place = merged
            for table in tables:
                place = place.setdefault(table, {})
                if not isinstance(place, dict):
                    raise _unknown_name(name, table, SensorConfig)
            place[key] = value
        return {_PRESET: DEFAULT} | merged

    def config(self) -> SensorConfig:
        """Return the sensor that the options describe.

        Raises:
            ScenarioError: the file cannot be read, or an argument or a name is wrong.
            SensorConfigError: a value is out of its range, or there is no such preset.
        """
        changes = self.changes()
        try:
            return sensor_of(changes)
        except FlybenchError as error:
            if self.sensor is None or self.sensor in _PRESETS:
                raise
            raise type(error)(f"{self.sensor}: {error}") from None

    def _base(self) -> dict[str, Any]:
        """Return the contents of --sensor in the form of the TOML file."""
        if self.sensor is None:
            return {}
        if self.sensor in _PRESETS:
            return {_PRESET: self.sensor}
        path = Path(self.sensor)
        if path.suffix != ".toml" and not path.is_file():
            near = get_close_matches(self.sensor, _PRESETS, n=1)
            remedy = f"Did you mean {near[0]}?" if near else "Give the path of an existing file."
            raise ScenarioError(
                f"--sensor is {self.sensor!r}. Allowed is a TOML file or one of "
                f"{', '.join(_PRESETS)}. {remedy}"
            )
        return read_toml(path, ScenarioError)[1]

    @property
    def preset(self) -> PresetName:
        """Name of the preset, which a file may state; `config` checks that it exists."""
        name: PresetName = self.changes()[_PRESET]
        return name

    @property
    def frames(self) -> bool:
        """True if the chip of the preset records APS frames."""
        return str(self.preset) not in WITHOUT_FRAMES

    @property
    def name(self) -> str:
        """Preset and a digest of all changes, as part of a folder name."""
        changes = self.changes()
        base = str(changes.pop(_PRESET))
        if not changes:
            return base
        return f"{base}_{hashlib.sha256(repr(_sorted(changes)).encode()).hexdigest()[:8]}"

    @property
    def is_default(self) -> bool:
        """True if no option is given."""
        return self.sensor is None and not self.set

    def arguments(self) -> list[str]:
        """Return the words of a command line that give these options."""
        words = [] if self.sensor is None else ["--sensor", shlex.quote(self.sensor)]
        return words + (["--set", *map(shlex.quote, self.set)] if self.set else [])


def sensor_of(changes: Mapping[str, Any]) -> SensorConfig:
    """Return the sensor of a preset with some parameters changed.

    Args:
        changes: values by the names of `SensorConfig`; "preset", "aps", "readout" and "biases" in
            the form of the TOML file (see the module docstring).

    Raises:
        ScenarioError: a sensor has no parameter of a name.
        SensorConfigError: a value is out of its range, or there is no such preset.
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
                f"{_BIASES}.{name} is {pair!r}. Allowed is a coarse and a fine code, such as "
                f"{name} = [5, 255]."
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
            f"{name} is {table!r}. Allowed is a table of values. Give them one by one, such as "
            f"{name}.{fields(kind)[0].name}."
        )
    _check_names(table, kind, f"{name}.")
    return table


def _check_names(values: Iterable[str], kind: type, prefix: str) -> None:
    for name in values:
        if name not in {field.name for field in fields(kind)}:
            raise _unknown_name(prefix + name, name, kind)


def _unknown_name(full: str, name: str, kind: type) -> ScenarioError:
    allowed = [field.name for field in fields(kind)]
    if kind is SensorConfig:
        allowed += [_PRESET, _BIASES]
    near = get_close_matches(name, allowed, n=1)
    remedy = f"Did you mean {near[0]}?" if near else "Correct the name or leave it out."
    return ScenarioError(
        f"A sensor has no parameter {full!r}. Allowed is one of {', '.join(allowed)}. {remedy}"
    )


def _check_once(names: Sequence[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise ScenarioError(
                f"--set has {name} {names.count(name)} times. Allowed is each name once. Leave out "
                "all but one."
            )


def _parsed(argument: str) -> tuple[str, Any]:
    """Return name and value of an argument NAME=VALUE."""
    name, equals, text = (part.strip() for part in argument.partition("="))
    if not (name and equals and text):
        raise ScenarioError(
            f"--set {argument!r} is not NAME=VALUE. Allowed is the name of a sensor parameter and "
            "its value, without blanks, such as theta_on=0.25."
        )
    if _BARE_WORD.fullmatch(text) and text not in {"true", "false", "inf", "nan"}:
        return name, text
    try:
        return name, parse_toml(f"value = {text}")["value"]
    except ValueError:
        raise ScenarioError(
            f"--set {argument!r} has a value that cannot be read. Allowed is a number, true, "
            "false, a word or [coarse, fine], such as theta_on=0.25."
        ) from None


def _sorted(values: Any) -> Any:
    """Return nested tables as nested lists, sorted by name."""
    if isinstance(values, Mapping):
        return [(name, _sorted(values[name])) for name in sorted(values)]
    return values
