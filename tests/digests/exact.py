"""SHA-256 of any value, computed from the exact bytes of its contents, without names of classes and
modules."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Case:
    """One digest.

    Attributes:
        compute: computes what is hashed.
        slow: True if it takes so long that `--fast` omits it.
    """

    compute: Callable[[], Any]
    slow: bool = False


def digest(value: Any) -> str:
    """The SHA-256 of a value, in hexadecimal digits."""
    found = hashlib.sha256()
    _feed(value, found.update)
    return found.hexdigest()


def _feed(value: Any, take: Callable[[bytes], None]) -> None:
    """Pass every part of a value to `take` as bytes; each type begins with a different letter."""
    if isinstance(value, np.ndarray):
        take(f"A{value.dtype.str}{value.shape}".encode())
        take(np.ascontiguousarray(value).tobytes())
    elif isinstance(value, np.generic):
        _feed(value.item(), take)
    elif isinstance(value, Enum):
        _feed(value.value, take)
    elif value is None or isinstance(value, bool | int):
        take(f"I{value};".encode())
    elif isinstance(value, float):
        take(b"F" + struct.pack("<d", value))
    elif isinstance(value, str | bytes):
        content = value.encode() if isinstance(value, str) else value
        take(f"S{len(content)};".encode() + content)
    elif is_dataclass(value):
        _feed((getattr(value, field.name) for field in fields(value)), take)
    elif isinstance(value, Mapping):
        _feed(value.items(), take)
    elif isinstance(value, Iterable):
        take(b"(")
        for part in value:
            _feed(part, take)
        take(b")")
    else:
        raise TypeError(f"{type(value).__name__} has no digest")
