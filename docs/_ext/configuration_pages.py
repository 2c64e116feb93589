"""Tables of the parameters, from the frozen dataclasses that hold them."""

import dataclasses
import re
import sys
from collections.abc import Iterator, Mapping
from enum import Enum
from typing import Any

import docstring_parser

from detector import (
    ContrastConfig,
    EdgeInformedConfig,
    FlyConfig,
    FrameFlyConfig,
    PlaneFitConfig,
    SpaceTimeFiltersConfig,
    SpikingDelaysConfig,
    TimeDifferenceConfig,
)
from emulator import ApsConfig, ReadoutConfig, SensorConfig
from flybench.checks import Range
from sim import CrossingConfig, Distractors, Illumination

SCENE = (CrossingConfig, Distractors, Illumination)
SENSOR = (SensorConfig, ReadoutConfig, ApsConfig)
DETECTORS = (
    FlyConfig,
    FrameFlyConfig,
    ContrastConfig,
    EdgeInformedConfig,
    PlaneFitConfig,
    SpaceTimeFiltersConfig,
    SpikingDelaysConfig,
    TimeDifferenceConfig,
)
NOTE = """\
This page is generated from the code. A value that no source gives is marked *assumed*. \
[Sources](../../sources.md) explains the short names of sources.
"""


def configuration_pages() -> dict[str, str]:
    """Return the text of each page by its file name."""
    return {
        "configuration/scene.md": _page("Parameters of the scene", SCENE),
        "configuration/sensor.md": _page("Parameters of the sensor", SENSOR),
        "configuration/detectors.md": _page("Parameters of the detectors", DETECTORS),
    }


def _page(title: str, classes: tuple[type, ...]) -> str:
    return "\n\n".join([f"# {title}", NOTE, *(_section(kind) for kind in classes)]) + "\n"


def _section(kind: type) -> str:
    """Return the table of one dataclass."""
    parsed = docstring_parser.parse(kind.__doc__ or "", docstring_parser.DocstringStyle.GOOGLE)
    meaning = {p.arg_name: p.description or "" for p in parsed.params}
    rows = ["| parameter, default | meaning |", "| --- | --- |"]
    ranges = _ranges(kind)
    for field in dataclasses.fields(kind):
        default = shown(_default(field))
        text = as_cell(meaning.get(field.name, ""))
        if field.name in ranges:
            text += f" Allowed: {_allowed(ranges[field.name])}."
        rows.append(f"| `{field.name}`<br>{default} | {text[:1].upper() + text[1:]} |")
    heading = f"## {kind.__name__}\n\n{as_cell(parsed.short_description or '')}"
    return heading + "\n\n" + "\n".join(rows)


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return None if field.default is dataclasses.MISSING else field.default


def shown(value: Any) -> str:
    """Return a value as a reader writes it in a TOML file or as an option."""
    if dataclasses.is_dataclass(value):
        return f"[{type(value).__name__}](#{type(value).__name__.lower()})"
    if isinstance(value, Enum):
        return f"`{value.value}`"
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "none"}[value]
    if isinstance(value, float):
        return f"{value:,.0f}" if 1e6 <= abs(value) < 1e10 else f"{value:,g}"
    if isinstance(value, tuple):
        return ", ".join(shown(part) for part in value) or "none"
    return f"{value:,}" if isinstance(value, int) else f"`{value}`"


def _ranges(kind: type) -> Mapping[str, Range]:
    module = sys.modules[kind.__module__]
    ranges: Mapping[str, Range] = getattr(module, "_RANGES", getattr(module, "RANGES", {}))
    return ranges


def _allowed(allowed: Range) -> str:
    return f"{shown(allowed.low)} to {shown(allowed.high)} {allowed.unit}".rstrip()


def as_cell(text: str) -> str:
    """Return text of a docstring as one line of a Markdown table."""
    return re.sub(r"\s+", " ", text).replace("|", r"\|").replace("$", r"\$").strip()


def differences(config: Any, base: Any, prefix: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield the name, the value and the base's value of each parameter that differs."""
    for field in dataclasses.fields(config):
        value, other = getattr(config, field.name), getattr(base, field.name)
        if dataclasses.is_dataclass(value):
            yield from differences(value, other, f"{prefix}{field.name}.")
        elif value != other:
            yield prefix + field.name, value, other
