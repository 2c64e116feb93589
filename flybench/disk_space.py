"""Full disks: check the free space before work, and name the disk when it is full."""

from __future__ import annotations

import errno
import re
import shutil
from pathlib import Path

from flybench.errors import FlybenchError, message_of

_FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
"""Errors of a full disk, an exhausted quota, and a file above the size limit of the process."""
_SHOWN_BYTES = 100_000
"""Smallest size that a message states."""
_IN_RUST = re.compile(r"\(os error (\d+)\)")
REMEDY = "Free some space, or choose another place."


def check_free_space(folder: Path, needed_bytes: int, error: type[FlybenchError]) -> None:
    """Check that there is room for an output of known or estimated size.

    Args:
        folder: folder to write to; it need not exist yet.
        needed_bytes: size of the output [bytes].
        error: class to raise.

    Raises:
        FlybenchError: of class `error`, if the disk has too little free space.
    """
    folder = folder.absolute()
    existing = next(path for path in (folder, *folder.parents) if path.exists())
    free = shutil.disk_usage(existing).free
    if free < needed_bytes:
        raise error(
            f"The disk of {folder} has {megabytes(free)} free. The output needs about "
            f"{megabytes(needed_bytes)}. {REMEDY}"
        )


def caused_by_full_disk(error: BaseException | None) -> bool:
    """Return True if a full disk caused an error, perhaps by way of other errors."""
    while error is not None:
        if isinstance(error, OSError) and error.errno in _FULL:
            return True
        # libraries in Rust give the number only as text
        in_rust = _IN_RUST.search(message_of(error))
        if in_rust and int(in_rust[1]) in _FULL:
            return True
        error = error.__cause__
    return False


def full_disk_message(target: Path, unfinished: Path) -> str:
    """Return the message that the disk is full, with the size of what was written.

    Args:
        target: final place of the output.
        unfinished: folder that holds what was written.
    """
    size = size_of(unfinished)
    written = f"{megabytes(size)} were written before, and more was needed. "
    return f"The disk of {target} is full. {written if size >= _SHOWN_BYTES else ''}{REMEDY}"


def size_of(folder: Path) -> int:
    """Return the size of all files in a folder, at any depth [bytes]."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def megabytes(size: int) -> str:
    """Format a number of bytes, such as "12.3 MB"."""
    return f"{size / 1e6:,.1f} MB"
