"""One reader a format: `read(path, options)` gives what the file says and an iterator of items."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import cast

from formats.columns import Options, Reading

Reader = Callable[[Path, Options], Reading]

_MODULES = {
    "aedat4": "aedat4",
    "aedat3": "aedat3",
    "aedat2": "aedat2",
    "evt2": "prophesee",
    "evt21": "evt21",
    "evt3": "prophesee",
    "dat": "prophesee",
    "es": "event_stream",
    "hdf5": "hdf5",
    "npz": "arrays",
    "npy": "arrays",
    "text": "text",
}


def reader_of(name: str) -> Reader:
    """The reader of a format, one of `magic.FORMATS`; its library is imported only now."""
    module = import_module(f"formats.readers.{_MODULES[name]}")
    return cast(Reader, getattr(module, f"read_{name}", None) or module.read)
