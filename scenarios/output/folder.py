"""A folder that is whole or absent: written under another name, then moved into place."""

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
"""All that a run writes; other commands list what they wrote in the summary, under "files"."""
GENERATOR = "flybench"


def check_output(folder: Path, is_ours: Callable[[Path], bool] | None = None) -> None:
    """Refuse an output folder that is somebody else's, before any work is done.

    Args:
        folder: to be written.
        is_ours: whether what is in a folder may be replaced; None: an earlier run's may.

    Raises:
        OutputError: it exists and holds anything but an earlier run, or cannot be made.
    """
    folder = folder.resolve()
    if folder == Path.cwd() or folder in Path.cwd().parents:
        raise OutputError(
            f"the output folder {folder} is the one that you are in, or holds it; allowed is a "
            "folder of its own, which can be replaced whole; choose one with --out"
        )
    parent = _nearest_existing(folder)
    if not parent.is_dir() or not os.access(parent, os.W_OK | os.X_OK):
        raise OutputError(
            f"the output folder {folder} cannot be made, since {parent} cannot be written to; "
            "choose another with --out"
        )
    if folder.exists() and not (is_ours or _is_ours)(folder):
        raise OutputError(
            f"the output folder {folder} exists and holds what was not written by flybench; "
            "allowed is a new folder, an empty one or one of an earlier run; choose another with "
            "--out"
        )


@contextmanager
def whole_folder(folder: Path) -> Iterator[Path]:
    """Give a temporary folder to fill; it takes `folder`'s place only where nothing failed.

    Raises:
        OutputError: as `check_output` does.
    """
    check_output(folder)
    folder = folder.resolve()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        holder = tempfile.TemporaryDirectory(prefix=f".{folder.name}.", dir=folder.parent)
    except OSError as error:
        raise OutputError(
            f"the output folder {folder} cannot be made ({error.strerror}); choose another with "
            "--out"
        ) from error
    with holder as scratch:
        work = Path(scratch) / "new"
        work.mkdir()
        yield work
        _replace(folder, work, aside=Path(scratch) / "old")


def write_summary(work: Path, summary: dict[str, Any]) -> None:
    """Write `summary.json` into a folder that holds all else, with a list of what is in it."""
    files = sorted({path.name for path in work.iterdir()} | {SUMMARY})
    text = json.dumps({"generator": GENERATOR} | summary | {"files": files}, indent=2)
    (work / SUMMARY).write_text(text + "\n", encoding="utf-8")


def _replace(folder: Path, work: Path, aside: Path) -> None:
    """Put `work` in `folder`'s place; what was there goes aside, and comes back on a failure."""
    had_one = folder.exists()
    if had_one:
        folder.rename(aside)
    try:
        work.rename(folder)
    except BaseException:
        if had_one:
            aside.rename(folder)
        raise


def _is_ours(folder: Path) -> bool:
    """Whether a folder is empty, or holds what a command wrote and nothing else."""
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
