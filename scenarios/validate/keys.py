"""The keys of a manifest: what each may hold, and how to write it."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import PurePath
from typing import Any

from flybench.direction import Direction
from formats import FORMATS, UNITS_US, FormatError, unit_us
from formats.column_order import check_order
from scenarios.errors import ScenarioError

RECORDINGS, WINDOWS = "recording", "window"
"""Names of the two lists of tables: [[recording]] and [[recording.window]]."""

_NAME = re.compile(r"[\w.-]+")
_SHA256 = re.compile(r"[0-9a-f]{64}")
_URL = re.compile(r"(https?://|doi:).+")
_LONGEST_S = 1e9
"""Latest time of a window [s]: no recording lasts 30 years."""


class ManifestError(ScenarioError):
    """A manifest cannot be read, holds an invalid value, or does not fit a recording."""


@dataclass(frozen=True)
class Key:
    """A key of a table.

    Attributes:
        is_valid: function that returns True if a value is allowed.
        allowed: what is allowed, for the message.
        example: a valid value in TOML, for the message.
        required: True if the key has to be given.
    """

    is_valid: Callable[[Any], bool]
    allowed: str
    example: str
    required: bool = False


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and bool(value.strip())


def _matches(pattern: re.Pattern[str]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, str) and pattern.fullmatch(value) is not None


def _is_file(value: Any) -> bool:
    return _is_text(value) and bool(PurePath(value).name) and not value.endswith("/")


def _is_time(value: Any) -> bool:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number and math.isfinite(value) and 0 <= value <= _LONGEST_S


def _is_list_of(count: int) -> Callable[[Any], bool]:
    def check(value: Any) -> bool:
        whole = isinstance(value, list) and all(type(v) is int and v >= 0 for v in value)
        return whole and len(value) == count

    return check


def _is_box(value: Any) -> bool:
    return _is_list_of(4)(value) and value[0] < value[2] and value[1] < value[3]


def _is_one_of(names: tuple[str, ...]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, str) and value in names


def _passes(check: Callable[[str], object]) -> Callable[[Any], bool]:
    def is_valid(value: Any) -> bool:
        try:
            check(value)
        except FormatError:
            return False
        return True

    return lambda value: isinstance(value, str) and is_valid(value)


_DIRECTIONS = tuple(d.value for d in Direction)

RECORDING_KEYS: Mapping[str, Key] = {
    "name": Key(_matches(_NAME), "letters, digits and _ . -", '"cradle"', required=True),
    "file": Key(_is_file, "the name or path of a file", '"cradle.aedat4"', required=True),
    "url": Key(
        _matches(_URL),
        "an address that begins with https://, http:// or doi:",
        '"https://example.org/cradle.aedat4"',
    ),
    "sha256": Key(
        _matches(_SHA256),
        "the 64 digits that `sha256sum FILE` prints, in small letters",
        '"97ea…" in full',
        required=True,
    ),
    "licence": Key(_is_text, "the name of the licence of the file", '"MIT"', required=True),
    "source": Key(
        _is_text,
        "text that says where the recording was published",
        '"doi.org/10.5281/zenodo.1"',
        required=True,
    ),
    "conditions": Key(
        _is_text, "text about the camera, the light and the motion", '"DAVIS346 at rest, indoors"'
    ),
    "size": Key(_is_list_of(2), "width and height of the sensor [px]", "[346, 260]"),
    "format": Key(_is_one_of(tuple(FORMATS)), f"one of {', '.join(FORMATS)}", '"aedat4"'),
    "time_unit": Key(
        _passes(unit_us),
        f"one of {', '.join(UNITS_US)}, with a number before it for times that count steps",
        '"us" or "1/30s"',
    ),
    "columns": Key(
        _passes(check_order),
        "the letters t, x, y and p in their order, and - for a column that is not read",
        '"txyp"',
    ),
}
"""Keys of [[recording]], besides its windows."""

WINDOW_KEYS: Mapping[str, Key] = {
    "direction": Key(
        _is_one_of(_DIRECTIONS), f"one of {', '.join(_DIRECTIONS)}", '"right"', required=True
    ),
    "from_s": Key(_is_time, "a time after the first event of the recording [s]", "0.06"),
    "to_s": Key(_is_time, "a time after the first event of the recording [s]", "0.21"),
    "crop": Key(
        _is_box, "[x0, y0, x1, y1] in whole pixels with x0 < x1 and y0 < y1", "[60, 0, 245, 65]"
    ),
    "conditions": Key(_is_text, "text about what happens in this window", '"the left ball falls"'),
}
"""Keys of [[recording.window]]."""


def check_keys(place: str, table: Mapping[str, Any], keys: Mapping[str, Key]) -> None:
    """Check the names and values of a table.

    Args:
        place: where the table is, for the message, such as "recording 2 (cradle)".
        table: its contents, without tables inside it.
        keys: the keys that it may hold.

    Raises:
        ManifestError: a key is unknown, is missing, or has an invalid value.
    """
    for name, value in table.items():
        if name not in keys:
            similar = get_close_matches(name, keys, n=1)
            remedy = f"Did you mean {similar[0]}?" if similar else "Remove it."
            raise ManifestError(
                f"{place} has the key {name} = {value!r}. Allowed is {', '.join(keys)}. {remedy}"
            )
        if not keys[name].is_valid(value):
            raise ManifestError(
                f"{place}: {name} is {value!r}. Allowed is {keys[name].allowed}. Write, for "
                f"example, {name} = {keys[name].example}."
            )
    for name, key in keys.items():
        if key.required and name not in table:
            raise ManifestError(
                f"{place} has no {name}. Every one needs it: {key.allowed}. Add, for example, "
                f"{name} = {key.example}."
            )
