"""Files that users and other programs provide, opened so that none can block or fill the memory."""

from __future__ import annotations

import errno
import io
import os
import select
import stat
from pathlib import Path
from typing import BinaryIO, cast

TEXT_MAX_BYTES = 16_000_000
"""Largest configuration file (assumed: a thousand times the largest of the examples)."""
_WAIT_S = 10.0
"""Longest wait for the first byte of a pipe (assumed)."""


def open_regular(path: Path, mode: str = "rb") -> BinaryIO:
    """Open a regular file; opening a FIFO or a device could block for ever.

    Args:
        path: the file.
        mode: mode of `open`, for bytes.

    Raises:
        OSError: the file cannot be opened, or is not a regular file.
    """
    return cast(BinaryIO, open(path, mode, opener=_regular))


def _regular(name: str, flags: int) -> int:
    descriptor = os.open(name, flags | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
    if stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.set_blocking(descriptor, True)
        return descriptor
    os.close(descriptor)
    raise OSError(errno.EINVAL, "it is not a regular file", name)


def open_lock(path: Path) -> BinaryIO:
    """Open a file to lock it, and create it if it is missing; not even a FIFO blocks.

    Raises:
        OSError: the file cannot be opened or created.
    """
    flags = os.O_RDWR | os.O_CREAT | os.O_NONBLOCK | os.O_CLOEXEC
    return os.fdopen(os.open(path, flags, 0o666), "rb")


def read_small_text(path: Path) -> str:
    """Return the text of a configuration file, or of a pipe such as /dev/stdin.

    Raises:
        OSError: the file cannot be read, is larger than `TEXT_MAX_BYTES`, is a device or socket, or
            is a FIFO to which nobody writes.
        UnicodeDecodeError: it is not text in UTF-8.
    """
    with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
        mode = os.fstat(file.fileno()).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not (stat.S_ISREG(mode) or stat.S_ISFIFO(mode) or os.isatty(file.fileno())):
            raise OSError(errno.EINVAL, "it is not a file or a pipe", str(path))
        if stat.S_ISFIFO(mode) and not select.select([file], [], [], _WAIT_S)[0]:
            raise OSError(errno.ETIMEDOUT, f"it sends no data for {_WAIT_S:.0f} s", str(path))
        os.set_blocking(file.fileno(), True)
        content = file.read(TEXT_MAX_BYTES + 1)
    if len(content) > TEXT_MAX_BYTES:
        raise OSError(errno.EINVAL, f"it has more than {TEXT_MAX_BYTES:,} bytes", str(path))
    with io.TextIOWrapper(io.BytesIO(content), encoding="utf-8") as text:
        return text.read()  # with any line endings
