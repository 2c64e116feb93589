"""Parsers: one module for each format.

Each has a function `read(path, options)` that returns the file's header and an iterator of its
events and frames.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import cast

from formats.columns import ParsedFile, ReadOptions

Reader = Callable[[Path, ReadOptions], ParsedFile]

_MODULES = {
    "aedat4": "aedat4",
    "aedat3": "aedat3",
    "aedat2": "aedat2",
    "evt2": "evt2",
    "evt21": "evt21",
    "evt3": "prophesee",
    "dat": "dat",
    "es": "event_stream",
    "hdf5": "hdf5",
    "npz": "arrays",
    "npy": "arrays",
    "text": "text",
}


def reader_of(name: str) -> Reader:
    """Return the read function of a format; the library that it needs is imported here.

    Args:
        name: name of the format, one of `formats.FORMATS`.
    """
    module = import_module(f"formats.readers.{_MODULES[name]}")
    return cast(Reader, getattr(module, f"read_{name}", None) or module.read)
