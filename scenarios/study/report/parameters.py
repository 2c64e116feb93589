"""Every parameter of a study, what it means and where it comes from, told by the code itself."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from scenarios.pipeline.registry import DETECTORS

_ATTRIBUTES = "\nAttributes:\n"
_ENTRY = re.compile(r" {4}(\w+): (.*)")


@dataclass(frozen=True)
class Parameter:
    """One parameter.

    Attributes:
        name: dotted where it is a part of a part.
        value: as text.
        note: what it means and its source, as its class says; empty where nothing does.
    """

    name: str
    value: str
    note: str


def flat(value: Any, prefix: str = "") -> Iterator[Parameter]:
    """All parameters in a mapping or a dataclass, whatever is nested in it.

    Args:
        value: the mapping, with text as keys, or the dataclass.
        prefix: of their names.
    """
    if isinstance(value, Mapping):
        parts, notes = dict(value), {}
    else:
        parts = {field.name: getattr(value, field.name) for field in fields(value)}
        notes = attribute_notes(type(value))
    for name, part in parts.items():
        if isinstance(part, Mapping) or (is_dataclass(part) and not isinstance(part, type)):
            yield from flat(part, f"{prefix}{name}.")
        else:
            yield Parameter(f"{prefix}{name}", _text(part), notes.get(name, ""))


def attribute_notes(kind: type) -> dict[str, str]:
    """What the "Attributes" of a class's docstring say, by name."""
    _, _, listed = (inspect.getdoc(kind) or "").partition(_ATTRIBUTES)
    notes: dict[str, str] = {}
    name = ""
    for line in listed.splitlines():
        if entry := _ENTRY.fullmatch(line):
            name = entry[1]
            notes[name] = entry[2]
        elif line.startswith(" " * 8) and name:
            notes[name] += " " + line.strip()
        elif line and not line.startswith(" "):
            break  # the next section
    return notes


def opening(kind: type) -> str:
    """What a class's docstring says before its attributes, in one line."""
    words, _, _ = (inspect.getdoc(kind) or "").partition(_ATTRIBUTES)
    return " ".join(words.split())


def method_config(method: str) -> Any | None:
    """The parameters of a detector of ours as a dataclass; None of one of the user's."""
    return DETECTORS[method].config if method in DETECTORS else None


def _text(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(map(_text, value)) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "none" if value is None else str(value)
