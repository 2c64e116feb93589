"""The journal of finished points: one line per point, on the disk before the point counts."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

from flybench.files import open_regular
from scenarios.errors import OutputError
from scenarios.sweep.measure import Results

_DIGITS = 16


class Journal:
    """Results of finished points by their keys, in a file that is only appended to.

    A line is valid if it begins with the digest of the rest. Other lines are ignored, such as an
    incomplete last line of a process that was killed.

    Attributes:
        done: results of all finished points, by key.
    """

    def __init__(self, path: Path) -> None:
        """Open or create the file, remove an incomplete last line, and read it.

        Raises:
            OutputError: the file cannot be read or written.
        """
        self._path = path
        try:
            self._file = open_regular(path, "a+b")
            self._truncate_incomplete_line()
            self.done = self.read(path)
            _sync_folder(path.parent)
        except OSError as error:
            raise self._error(error) from error

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(OSError):  # if the disk is full, `add` has said so
            self._file.close()

    @staticmethod
    def read(path: Path) -> dict[str, Results]:
        """Return the results of the finished points in a file, without changing it."""
        records = (_record(line) for line in path.read_bytes().split(b"\n"))
        return dict(filter(None, records))

    def add(self, finished: Iterable[tuple[str, Results]]) -> None:
        """Append finished points; when this returns, they are on the disk.

        Raises:
            OutputError: the points cannot be written.
        """
        new = {key: results for key, results in finished if key not in self.done}
        try:
            self._file.write(b"".join(_line(key, results) for key, results in new.items()))
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            raise self._error(error) from error
        self.done |= new

    def _truncate_incomplete_line(self) -> None:
        self._file.seek(0)
        self._file.truncate(self._file.read().rfind(b"\n") + 1)

    def _error(self, error: OSError) -> OutputError:
        return OutputError(
            f"{self._path} cannot be written ({error.strerror}). Its contents are kept. Free some "
            "disk space, or choose another folder with --out. Then start again."
        )


def _line(key: str, results: Results) -> bytes:
    body = json.dumps({"point": key, "results": results}).encode()
    return _digest(body) + b" " + body + b"\n"


def _record(line: bytes) -> tuple[str, dict[str, Any]] | None:
    """Return the key and results of a line; None if the line is damaged."""
    digest, _, body = line.partition(b" ")
    if digest != _digest(body):
        return None
    record = json.loads(body)
    return record["point"], record["results"]


def _digest(body: bytes) -> bytes:
    return hashlib.sha256(body).hexdigest()[:_DIGITS].encode()


def _sync_folder(folder: Path) -> None:
    """Write the folder's entries to the disk, so that a new file survives a power failure."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
