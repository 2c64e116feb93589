"""A folder that is whole or absent: written under another name, then moved into place."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from scenarios.errors import OutputError

SUMMARY = "summary.json"
GENERATOR = "flybench"


def check_output(folder: Path) -> None:
    """Refuse an output folder that is somebody else's, before any work is done.

    Raises:
        OutputError: it exists and is no run of ours, or cannot be made.
    """
    if folder.exists() and not _is_ours(folder):
        raise OutputError(
            f"the output folder {folder} exists and was not written by flybench; allowed is a new "
            "folder, an empty one or one of an earlier run; choose another with --out"
        )
    parent = _nearest_existing(folder)
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise OutputError(
            f"the output folder {folder} cannot be made, since {parent} cannot be written to; "
            "choose another with --out"
        )


@contextmanager
def whole_folder(folder: Path) -> Iterator[Path]:
    """Give a temporary folder to fill; it takes `folder`'s place only where nothing failed.

    Raises:
        OutputError: as `check_output` does.
    """
    check_output(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    work = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    work.chmod(0o755)
    try:
        yield work
        if folder.exists():
            shutil.rmtree(folder)
        work.replace(folder)
    except BaseException:
        shutil.rmtree(work, ignore_errors=True)
        raise


def _is_ours(folder: Path) -> bool:
    if not folder.is_dir():
        return False
    if not any(folder.iterdir()):
        return True
    try:
        summary = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(summary, dict) and summary.get("generator") == GENERATOR


def _nearest_existing(folder: Path) -> Path:
    return next(parent for parent in folder.absolute().parents if parent.exists())
