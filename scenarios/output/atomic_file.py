"""Write a file atomically: under a temporary name that replaces the final one at the end."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from scenarios.errors import OutputError


def check_output_file(path: Path, option: str) -> None:
    """Check that a file can be written, before any work is done.

    Args:
        path: path of the file.
        option: command-line option that the path comes from, such as "--plot".

    Raises:
        OutputError: the path is a folder, or its folder does not exist or is write-protected.
    """
    if path.is_dir():
        raise OutputError(f"{option} {path} is a folder. Give the name of a file in it.")
    folder = path.absolute().parent
    if not folder.is_dir():
        raise OutputError(
            f"{option} {path} cannot be written: the folder {folder} does not exist. Create it "
            "first."
        )
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(
            f"{option} {path} cannot be written: the folder {folder} is write-protected. Choose "
            "another place."
        )


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path to write to; it replaces `path` if the block raises no error.

    The temporary file has the name of `path`, in a temporary folder beside it.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        holder = tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.absolute().parent)
    except OSError as error:
        raise OutputError(
            f"{path} cannot be written ({error.strerror}). Choose another place."
        ) from error
    with holder as folder:
        work = Path(folder) / path.name
        yield work
        work.replace(path)
