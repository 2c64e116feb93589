"""Write a folder atomically: under a temporary name that replaces the final one at the end."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from flybench.disk_space import check_free_space
from flybench.files import read_small_text
from flybench.unfinished import UnfinishedOutput, free_name
from scenarios.errors import OutputError

RECORDING = "recording.rrd"
EVENTS = "events.h5"
TRUTH = "truth.csv"
ESTIMATES = "estimates.csv"
SUMMARY = "summary.json"
GENERATOR = "flybench"
_SHOWN = 3
"""Most files of others that a message names."""


def check_output_folder(
    folder: Path,
    *,
    needed_bytes: int,
    other_files: Callable[[Path], list[str]] | None = None,
) -> None:
    """Check that an output folder can be written, before any work is done.

    Args:
        folder: path of the folder.
        needed_bytes: estimated size of the output [bytes].
        other_files: function that lists the files of an existing folder that flybench did not
            write; None: those that its summary does not list, and the folder is replaced as a
            whole.

    Raises:
        OutputError: the folder holds files that flybench did not write, it is a mount point, it
            cannot be created, or its disk has too little free space.
    """
    folder = folder.resolve()
    if folder == Path.cwd() or folder in Path.cwd().parents:
        raise OutputError(
            f"The output folder {folder} contains the current folder. Allowed is a separate folder "
            "that can be replaced as a whole. Choose one with --out."
        )
    if other_files is None and os.path.ismount(folder):
        raise OutputError(
            f"The output folder {folder} is a mount point, which cannot be replaced. Choose a "
            "folder in it with --out."
        )
    parent = _nearest_existing(folder)
    if not parent.is_dir() or not os.access(parent, os.W_OK | os.X_OK):
        raise OutputError(
            f"The output folder {folder} cannot be created: {parent} is write-protected or not a "
            "folder. Choose another with --out."
        )
    if folder.exists() and (others := (other_files or unlisted_files)(folder)):
        raise OutputError(
            f"The output folder {folder} contains files that were not written by flybench: "
            f"{_named(others)}. Allowed is a new folder, an empty one or one of an earlier run. "
            "Move these files, or choose another folder with --out."
        )
    check_free_space(folder, needed_bytes, OutputError)


@contextmanager
def atomic_folder(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder to fill; it replaces `folder` if the block raises no error.

    It is locked: another process cannot write the same folder at the same time. Beside it, in the
    folder `finished`, the block may keep parts of the output for a later attempt.

    Raises:
        OutputError: the folder may not be replaced, cannot be created, is being written by another
            process, or its disk is full.
    """
    check_output_folder(folder, needed_bytes=0)
    folder = folder.resolve()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"The output folder {folder} cannot be created ({error.strerror}). Choose another with "
            "--out."
        ) from error
    with UnfinishedOutput(folder, OutputError) as output:
        yield output.new
        _replace(output)


def write_summary(work: Path, summary: dict[str, Any]) -> None:
    """Write `summary.json`, with a list of all files in the folder; call this last.

    Only listed files are ever replaced or removed by a later command.

    Args:
        work: the folder.
        summary: content of the file, besides the program's name and the list.
    """
    files = sorted({*_files(work), SUMMARY})
    text = json.dumps({"generator": GENERATOR} | summary | {"files": files}, indent=2)
    (work / SUMMARY).write_text(text + "\n", encoding="utf-8")


def unlisted_files(folder: Path) -> list[str]:
    """Return the files in a folder, at any depth, that its `summary.json` does not list."""
    if not folder.is_dir():
        return [folder.name]
    listed: Any = None
    try:
        summary = json.loads(read_small_text(folder / SUMMARY))
        if isinstance(summary, dict) and summary.get("generator") == GENERATOR:
            listed = summary.get("files")
    except (OSError, ValueError, RecursionError):
        pass
    names = set(map(str, listed)) if isinstance(listed, list) else set()
    return sorted(set(_files(folder)) - names)


def _files(folder: Path) -> Iterator[str]:
    """Yield the paths of all files and links in a folder, relative to it."""
    for place, folders, files in os.walk(folder):
        links = [name for name in folders if (Path(place) / name).is_symlink()]
        for name in (*files, *links):
            yield (Path(place) / name).relative_to(folder).as_posix()


def _replace(output: UnfinishedOutput) -> None:
    """Move the new folder to its place, or beside an earlier one that cannot be replaced."""
    folder = output.target
    try:
        others = _move_aside(output)
        if not others:
            output.new.rename(folder)
            return
        reason = f"got files meanwhile that were not written by flybench: {_named(others)}"
    except OSError as failure:
        reason = f"cannot be replaced ({failure.strerror})"
    if output.old.exists():
        output.old.rename(folder)
    place = free_name(folder)
    output.new.rename(place)
    raise OutputError(
        f"The output folder {folder} {reason}. It is unchanged, and the output is in {place}."
    )


def _move_aside(output: UnfinishedOutput) -> list[str]:
    """Move an earlier folder away, and return the files in it that flybench did not write."""
    if not output.target.exists():
        return []
    output.target.rename(output.old)
    return unlisted_files(output.old)


def _named(files: list[str]) -> str:
    more = f" and {len(files) - _SHOWN} more" if len(files) > _SHOWN else ""
    return ", ".join(files[:_SHOWN]) + more


def _nearest_existing(folder: Path) -> Path:
    return next(parent for parent in folder.parents if parent.exists())
