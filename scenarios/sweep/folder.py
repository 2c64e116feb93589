"""The folder of a sweep: used by one process at a time, and resumable."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from flybench.files import open_regular
from scenarios.errors import OutputError
from scenarios.output.atomic_folder import SUMMARY, check_output_folder
from scenarios.output.locked_folder import locked_folder

LOCK, JOURNAL, COPY = "flybench-sweep.lock", "points.jsonl", "sweep.toml"
CSV, PARQUET = "results.csv", "results.parquet"
RESULTS = (SUMMARY, CSV, PARQUET)
NEEDED_BYTES = 1_000_000
"""Room for a thousand points, which take 1 kB each [bytes] (measured)."""
FILES = frozenset({LOCK, JOURNAL, COPY, *RESULTS})


def check_folder(folder: Path) -> None:
    """Check that a folder can hold a sweep.

    Raises:
        OutputError: the folder exists and holds anything but a sweep, or cannot be created.
    """
    check_output_folder(folder, needed_bytes=NEEDED_BYTES, other_files=_other_files)


def _other_files(folder: Path) -> list[str]:
    if not folder.is_dir():
        return [folder.name]
    names = {path.name for path in folder.iterdir()}
    own = FILES | {_part(name) for name in FILES} if LOCK in names else frozenset()
    return sorted(names - own)


@contextmanager
def sweep_folder(folder: Path) -> Iterator[Path]:
    """Create or reopen the folder and lock it for this process.

    Raises:
        OutputError: the folder fails `check_folder`, or another process uses it.
    """
    check_folder(folder)
    with locked_folder(folder, LOCK, "running the sweep"):
        yield folder


def drop_results(folder: Path) -> None:
    """Remove the tables of an earlier run, which may be of other points."""
    for name in RESULTS:
        (folder / name).unlink(missing_ok=True)


@contextmanager
def durable_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path to write to; move it into place when the data is on the disk.

    A process that is killed leaves only a temporary file that `check_folder` accepts.

    Raises:
        OutputError: the file cannot be written.
    """
    part = path.with_name(_part(path.name))
    try:
        yield part
        with open_regular(part) as file:
            os.fsync(file.fileno())
        part.replace(path)
    except OSError as error:
        with suppress(OSError):
            part.unlink()
        raise OutputError(
            f"{path} cannot be written ({error.strerror}). Free some disk space, or choose another "
            "folder with --out. Then start again."
        ) from error


def _part(name: str) -> str:
    return f".{name}.part"
