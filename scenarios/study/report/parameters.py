"""All parameters of a study, with the meaning and the source given in the code."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from docstring_parser import Docstring, DocstringStyle, parse

from scenarios.pipeline.registry import DETECTORS


@dataclass(frozen=True)
class Parameter:
    """One parameter.

    Attributes:
        name: name; dotted for a nested parameter.
        value: value as text.
        note: meaning and source, from the docstring of its class; empty if there is none.
    """

    name: str
    value: str
    note: str


def flatten_parameters(value: Any, prefix: str = "") -> Iterator[Parameter]:
    """Yield all parameters of a mapping or a dataclass, including nested ones.

    Args:
        value: a mapping with text as keys, or a dataclass.
        prefix: prefix of their names.
    """
    if isinstance(value, Mapping):
        parts, notes = dict(value), {}
    else:
        parts = {field.name: getattr(value, field.name) for field in fields(value)}
        notes = attribute_notes(type(value))
    for name, part in parts.items():
        if isinstance(part, Mapping) or (is_dataclass(part) and not isinstance(part, type)):
            yield from flatten_parameters(part, f"{prefix}{name}.")
        else:
            yield Parameter(f"{prefix}{name}", _text(part), notes.get(name, ""))


def attribute_notes(kind: type) -> dict[str, str]:
    """Return the descriptions of the attributes in the docstrings of a class and its bases."""
    return {
        item.arg_name: _one_line(item.description)
        for base in reversed(kind.__mro__)
        for item in _docstring(base).params
    }


def class_description(kind: type) -> str:
    """Return the docstring of a class up to its first section, as one line."""
    return _one_line(_docstring(kind).description)


def method_config(method: str) -> Any | None:
    """Return the configuration of one of our detectors, a dataclass; None for a user's class."""
    return DETECTORS[method].config if method in DETECTORS else None


def _docstring(kind: type) -> Docstring:
    return parse(inspect.getdoc(kind) or "", DocstringStyle.GOOGLE)


def _one_line(text: str | None) -> str:
    return " ".join((text or "").split())


def _text(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(map(_text, value)) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "none" if value is None else str(value)
