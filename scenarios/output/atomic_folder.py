"""Write a folder atomically: under a temporary name that replaces the final one at the end."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from scenarios.errors import OutputError

RECORDING = "recording.rrd"
EVENTS = "events.h5"
TRUTH = "truth.csv"
ESTIMATES = "estimates.csv"
SUMMARY = "summary.json"
FILES = frozenset({RECORDING, EVENTS, TRUTH, ESTIMATES, SUMMARY})
"""Files of a run. Other commands list their files in the summary under "files"."""
GENERATOR = "flybench"


def check_output_folder(folder: Path, may_replace: Callable[[Path], bool] | None = None) -> None:
    """Check that an output folder can be written, before any work is done.

    Args:
        folder: path of the folder.
        may_replace: function that returns True if an existing folder may be replaced; None: allow
            empty folders and folders with nothing but the output of a flybench command.

    Raises:
        OutputError: the folder may not be replaced, or cannot be created.
    """
    folder = folder.resolve()
    if folder == Path.cwd() or folder in Path.cwd().parents:
        raise OutputError(
            f"The output folder {folder} contains the current folder. Allowed is a separate folder "
            "that can be replaced as a whole. Choose one with --out."
        )
    parent = _nearest_existing(folder)
    if not parent.is_dir() or not os.access(parent, os.W_OK | os.X_OK):
        raise OutputError(
            f"The output folder {folder} cannot be created: {parent} is write-protected or not a "
            "folder. Choose another with --out."
        )
    if folder.exists() and not (may_replace or _is_output)(folder):
        raise OutputError(
            f"The output folder {folder} contains files that were not written by flybench. Allowed "
            "is a new folder, an empty one or one of an earlier run. Choose another with --out."
        )


@contextmanager
def atomic_folder(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder to fill; it replaces `folder` if the block raises no error.

    Raises:
        OutputError: the folder may not be replaced, or cannot be created.
    """
    check_output_folder(folder)
    folder = folder.resolve()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        holder = tempfile.TemporaryDirectory(prefix=f".{folder.name}.", dir=folder.parent)
    except OSError as error:
        raise OutputError(
            f"The output folder {folder} cannot be created ({error.strerror}). Choose another with "
            "--out."
        ) from error
    with holder as scratch:
        work = Path(scratch) / "new"
        work.mkdir()
        yield work
        _replace(folder, work, aside=Path(scratch) / "old")


def write_summary(work: Path, summary: dict[str, Any]) -> None:
    """Write `summary.json`, with a list of all files in the folder; call this last.

    Args:
        work: the folder.
        summary: content of the file, besides the program's name and the list.
    """
    files = sorted({path.name for path in work.iterdir()} | {SUMMARY})
    text = json.dumps({"generator": GENERATOR} | summary | {"files": files}, indent=2)
    (work / SUMMARY).write_text(text + "\n", encoding="utf-8")


def _replace(folder: Path, work: Path, aside: Path) -> None:
    """Rename `work` to `folder`; an existing folder moves to `aside`, and back on an error."""
    existed = folder.exists()
    if existed:
        folder.rename(aside)
    try:
        work.rename(folder)
    except BaseException:
        if existed:
            aside.rename(folder)
        raise


def _is_output(folder: Path) -> bool:
    """Return True if a folder is empty, or contains nothing but the output of a command."""
    try:
        names = {path.name for path in folder.iterdir()}
        if not names:
            return True
        summary = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    if not isinstance(summary, dict) or summary.get("generator") != GENERATOR:
        return False
    listed = summary.get("files", ())
    return names <= FILES.union(listed if isinstance(listed, list) else ())


def _nearest_existing(folder: Path) -> Path:
    return next(parent for parent in folder.parents if parent.exists())
