"""File for HDF5, which crashes the process if a write fails."""

from __future__ import annotations

from pathlib import Path
from typing import IO, Any


class LastingFile:
    """A file that never fails: after an error it discards what is written, and keeps the error."""

    def __init__(self, path: Path) -> None:
        """Create the file.

        Raises:
            OSError: the file cannot be created.
        """
        self._file: IO[bytes] = path.open("w+b", buffering=0)
        self._error: OSError | None = None

    def check(self) -> None:
        """Raise the first error, if there was one.

        Raises:
            OSError: the file cannot be written, for example because the disk is full.
        """
        if self._error is not None:
            raise self._error

    def write(self, data: Any) -> int:
        """Write bytes at the current position."""
        left = memoryview(data).cast("B")
        size = left.nbytes
        try:
            while left and self._error is None:
                left = left[self._file.write(left) :]
        except OSError as error:
            self._error = error
        return size

    def truncate(self, size: int | None = None) -> int:
        """Set the size of the file."""
        try:
            return self._file.truncate(size)
        except OSError as error:
            self._error = self._error or error
            return size or 0

    def read(self, size: int) -> bytes:
        """Read bytes at the current position; zeros where an error has lost them."""
        return self._file.read(size).ljust(size, b"\0")

    def seek(self, offset: int, whence: int = 0) -> int:
        """Move to a position."""
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        """Return the current position."""
        return self._file.tell()

    def flush(self) -> None:
        """Do nothing: there is no buffer."""

    def close(self) -> None:
        """Close the file."""
        self._file.close()
