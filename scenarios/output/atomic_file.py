"""Write a file atomically: under a temporary name that replaces the final one at the end."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from flybench.unfinished import UnfinishedOutput, check_new_file
from scenarios.errors import OutputError


def check_output_file(
    path: Path, option: str, *, overwrite: bool, sources: Sequence[Path] = ()
) -> None:
    """Check that a file can be written, before any work is done.

    Args:
        path: path of the file.
        option: command-line option that the path comes from, such as "--plot".
        overwrite: True to replace an existing file.
        sources: files that the command reads.

    Raises:
        OutputError: the path is one of the sources or a folder, its folder does not exist or is
            write-protected, or the file exists and may not be overwritten.
    """
    if any(_is_same_file(path, source) for source in sources):
        raise OutputError(
            f"{option} is {path}, which is a file to read. Allowed is a new file, also with "
            "--overwrite. Choose another name."
        )
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
    check_new_file(path, overwrite=overwrite, error=OutputError)


def _is_same_file(path: Path, source: Path) -> bool:
    """Return True if two paths lead to the same existing file."""
    return path.exists() and source.exists() and path.samefile(source)


@contextmanager
def atomic_file(path: Path, *, overwrite: bool) -> Iterator[Path]:
    """Yield a temporary path to write to; it becomes `path` if the block raises no error.

    The temporary file has the name of `path`, in a temporary folder beside it.

    Args:
        path: path of the file.
        overwrite: True to replace an existing file.

    Raises:
        OutputError: the file cannot be written, another process is writing it, its disk is full, or
            it was created meanwhile and may not be overwritten.
    """
    with UnfinishedOutput(path.absolute(), OutputError) as output:
        yield output.new / path.name
        output.publish_file(overwrite=overwrite)
