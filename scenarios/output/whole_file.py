"""A file that is whole or absent: written under another name, then moved into place."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from scenarios.errors import OutputError


def check_place(path: Path, option: str) -> None:
    """Refuse a place where no file can be written, before any work is done.

    Args:
        path: to be written.
        option: what the user chose it with, such as "--plot".

    Raises:
        OutputError: it is a folder, or its folder is not there or cannot be written to.
    """
    if path.is_dir():
        raise OutputError(f"{option} {path} is a folder; give the name of a file in it")
    folder = path.absolute().parent
    if not folder.is_dir():
        raise OutputError(f"{option} {path} has no folder to lie in; make {folder} first")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(
            f"{option} {path} cannot be written, since the folder {folder} does not allow it; "
            "choose another place"
        )


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a temporary name to write to; it takes `path`'s place only where nothing failed.

    The name ends as `path` does, and lies in a folder of its own beside it.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        holder = tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.absolute().parent)
    except OSError as error:
        raise OutputError(
            f"{path} cannot be written ({error.strerror}); choose another place"
        ) from error
    with holder as folder:
        work = Path(folder) / path.name
        yield work
        work.replace(path)
