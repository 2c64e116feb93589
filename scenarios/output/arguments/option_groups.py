"""Groups of options in the help of a command, by what they are about.

A command is a flat dataclass. `GROUPS` in it names groups of its fields, in the order of the help;
fields in no group come first. If a field has the name of a group, it is itself a dataclass of
options, which belong to that group.
"""

from __future__ import annotations

import ast
import dataclasses
import inspect
from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Any, get_type_hints

import tyro

_SUFFIX = "_group"


def grouped(command: Any) -> Any:
    """Return a class with the options of a command in groups; a class without groups as it is."""
    groups: Mapping[str, tuple[str, ...]] = getattr(command, "GROUPS", {})
    if not groups:
        return command
    items = _described_fields(command)
    in_groups = {name for names in groups.values() for name in names}.union(groups)
    members = [item for name, item in items.items() if name not in in_groups]
    for group, names in groups.items():
        if group in items:
            members.append(items[group])
        if names:
            kind: Any = _dataclass(group, [items[name] for name in names])
            options: Any = Annotated[kind, tyro.conf.arg(name=group), tyro.conf.OmitArgPrefixes]
            members.append((group + _SUFFIX, options, dataclasses.field(default_factory=kind)))
    return _dataclass(command.__name__, members)


def flat(command: Any, parsed: Any) -> Any:
    """Return a command with the values that were parsed for `grouped` of it."""
    if not getattr(command, "GROUPS", {}) or isinstance(parsed, command):
        return parsed
    values = dict(vars(parsed))
    for group in [name for name in values if name.endswith(_SUFFIX)]:
        values |= vars(values.pop(group))
    return command(**values)


def _dataclass(name: str, members: list[Any]) -> Any:
    return dataclasses.make_dataclass(name, members, kw_only=True)


def _described_fields(command: Any) -> dict[str, Any]:
    """Return name, type with help, and default of each field, for `make_dataclass`."""
    hints, texts = get_type_hints(command, include_extras=True), _texts(command)
    return {
        item.name: (
            item.name,
            Annotated[hints[item.name], tyro.conf.arg(help=texts[item.name])]
            if item.name in texts
            else hints[item.name],
            dataclasses.field(default=item.default, default_factory=item.default_factory),
        )
        for item in dataclasses.fields(command)
    }


def _texts(command: Any) -> dict[str, str]:
    """Return the text below each field, as the parser finds it in a class that is not made here."""
    (definition,) = ast.parse(inspect.getsource(command)).body
    assert isinstance(definition, ast.ClassDef)
    return {
        ast.unparse(name.target): str(text.value.value)
        for name, text in pairwise(definition.body)
        if isinstance(name, ast.AnnAssign)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
    }
