"""File that Rerun writes through a pipe, so that a full disk is an error and not a crash."""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress
from pathlib import Path
from threading import Thread

_PIPE_BYTES = 1 << 20
"""Largest pipe that Linux allows every user by default [bytes]."""


class PipedFile:
    """Writes what arrives in a pipe to a file, in a thread.

    After an error it discards the rest, so that the writer at the other end never fails.
    """

    def __init__(self, path: Path) -> None:
        """Create the file, and start to read from the pipe.

        Raises:
            OSError: the file cannot be created.
        """
        path.unlink(missing_ok=True)  # a process that was killed may still have it open
        self._file = path.open("wb", buffering=0)
        self._error: OSError | None = None
        self._pipe, self._entry = os.pipe()
        with suppress(OSError, AttributeError):  # a user's quota of pipes; systems without the call
            fcntl.fcntl(self._pipe, fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
        self.entry = Path(f"/proc/self/fd/{self._entry}")
        """Path to write to."""
        self._thread = Thread(target=self._copy, daemon=True)
        self._thread.start()

    def check(self) -> None:
        """Raise the error of the file, if there was one.

        Raises:
            OSError: the file cannot be written, for example because the disk is full.
        """
        if self._error is not None:
            raise self._error

    def opened(self) -> None:
        """Close this process's own end, once the writer has opened the path."""
        os.close(self._entry)

    def close(self) -> None:
        """Wait until the writer has closed its end and everything is in the file.

        Raises:
            OSError: the file could not be written.
        """
        self._thread.join()
        self.check()

    def _copy(self) -> None:
        with self._file, os.fdopen(self._pipe, "rb", buffering=0) as pipe:
            while block := pipe.read(_PIPE_BYTES):
                if self._error is None:
                    self._write(memoryview(block))

    def _write(self, block: memoryview) -> None:
        try:
            while block:
                block = block[self._file.write(block) :]
        except OSError as error:
            self._error = error
