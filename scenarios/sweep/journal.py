"""Finished points, one line each: written through to the disk before they count as finished."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from scenarios.errors import OutputError
from scenarios.sweep.measure import Results

_DIGITS = 16


class Journal:
    """Results by the keys of their points, in a file that only grows.

    A line is whole if it begins with the digest of what follows. Whatever else is found, such as
    the beginning of a line that a killed process left at the end, counts as not written.

    Attributes:
        done: results of all finished points.
    """

    def __init__(self, path: Path) -> None:
        """Open or make the file, read it, and cut off what was not finished.

        Raises:
            OutputError: it cannot be read or written.
        """
        self._path = path
        try:
            self._file = path.open("a+b")
            self._cut_off_the_torn()
            self.done = self.read(path)
            _sync_folder(path.parent)
        except OSError as error:
            raise self._refusal(error) from error

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    @staticmethod
    def read(path: Path) -> dict[str, Results]:
        """Results of the finished points in a file, which is left as it is."""
        records = (_record(line) for line in path.read_bytes().split(b"\n"))
        return dict(filter(None, records))

    def add(self, finished: Iterable[tuple[str, Results]]) -> None:
        """Write points; once this returns, they are on the disk.

        Raises:
            OutputError: they cannot be written.
        """
        new = {key: results for key, results in finished if key not in self.done}
        try:
            self._file.write(b"".join(_line(key, results) for key, results in new.items()))
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            raise self._refusal(error) from error
        self.done |= new

    def _cut_off_the_torn(self) -> None:
        self._file.seek(0)
        self._file.truncate(self._file.read().rfind(b"\n") + 1)

    def _refusal(self, error: OSError) -> OutputError:
        return OutputError(
            f"{self._path} cannot be written ({error.strerror}); what it holds is kept; make room, "
            "or choose another folder with --out, and start again"
        )


def _line(key: str, results: Results) -> bytes:
    body = json.dumps({"point": key, "results": results}).encode()
    return _digest(body) + b" " + body + b"\n"


def _record(line: bytes) -> tuple[str, dict[str, Any]] | None:
    """A point and its results; None where the line is not as it was written."""
    digest, _, body = line.partition(b" ")
    if digest != _digest(body):
        return None
    said = json.loads(body)
    return said["point"], said["results"]


def _digest(body: bytes) -> bytes:
    return hashlib.sha256(body).hexdigest()[:_DIGITS].encode()


def _sync_folder(folder: Path) -> None:
    """Write through that a file was made."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
