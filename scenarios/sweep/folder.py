"""A sweep's folder: one process at a time, resumed as long as it is there."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from scenarios.errors import OutputError
from scenarios.output.atomic_folder import SUMMARY, check_output_folder

LOCK, JOURNAL, COPY = "flybench-sweep.lock", "points.jsonl", "sweep.toml"
CSV, PARQUET = "results.csv", "results.parquet"
RESULTS = (SUMMARY, CSV, PARQUET)
FILES = frozenset({LOCK, JOURNAL, COPY, *RESULTS})


def check_folder(folder: Path) -> None:
    """Refuse a folder that is not a sweep's.

    Raises:
        OutputError: it exists and holds anything but a sweep, or cannot be made.
    """
    check_output_folder(folder, _is_a_sweeps)


def _is_a_sweeps(folder: Path) -> bool:
    if not folder.is_dir():
        return False
    names = {path.name for path in folder.iterdir()}
    return not names or (LOCK in names and names <= FILES | {_part(name) for name in FILES})


@contextmanager
def sweep_folder(folder: Path) -> Iterator[Path]:
    """Make the folder, or take the one that is there, for this process alone.

    Raises:
        OutputError: as `check_folder` does, or another process is at it.
    """
    check_folder(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / LOCK).open("wb")
    except OSError as error:
        raise OutputError(
            f"the output folder {folder} cannot be made ({error.strerror}); choose another with "
            "--out"
        ) from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OutputError(
                f"another process is at the sweep in {folder}; allowed is one at a time; wait for "
                "it, or choose another folder with --out"
            ) from None
        yield folder


def drop_results(folder: Path) -> None:
    """Remove tables of an earlier run, which need not be of the same points."""
    for name in RESULTS:
        (folder / name).unlink(missing_ok=True)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a path to write to; the file takes its place once it is whole and on the disk.

    Raises:
        OutputError: it cannot be written.
    """
    part = path.with_name(_part(path.name))
    try:
        yield part
        with part.open("rb") as file:
            os.fsync(file.fileno())
        part.replace(path)
    except OSError as error:
        with suppress(OSError):
            part.unlink()
        raise OutputError(
            f"{path} cannot be written ({error.strerror}); make room, or choose another folder "
            "with --out, and start again"
        ) from error


def _part(name: str) -> str:
    return f".{name}.part"
