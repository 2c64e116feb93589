"""Read a file through a separate process, so that a damaged file cannot crash this one.

The decoding libraries are written in C, C++ and Rust. A damaged file can make them run out of
memory, abort the process or hang. The separate process has limited memory, and this module turns
whatever happens to it into an error message. If a second core is free, the separate process costs
no additional time.
"""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from formats.columns import ReadOptions
from formats.errors import FormatError
from formats.parser_process import DAMAGED, MESSAGE, TOO_LARGE, TOO_LARGE_OR_ABORTED

TIMEOUT_S = 60.0
"""Longest wait for a message (assumed: long enough for a slow disk on a busy machine) [s]."""

_BOOTSTRAP = (
    "import sys, types; package = types.ModuleType('formats'); package.__path__ = [sys.argv[2]]; "
    "sys.modules['formats'] = package; sys.path.append(sys.argv[3]); "
    "from formats.parser_process import main; main()"
)
"""Imports the parser without `formats/__init__.py`, which imports the emulator."""

_ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "RUST_BACKTRACE": "0",
    "MALLOC_ARENA_MAX": "2",
}


class IsolatedReader:
    """A running parser process and the messages that it sends. Use as a context manager."""

    def __init__(self, path: Path, name: str, options: ReadOptions) -> None:
        """Start to parse a file.

        Args:
            path: path of the file.
            name: name of its format, one of `formats.FORMATS`.
            options: what the user states about the file.
        """
        self._path = path
        job = {"path": str(path), "format": name, "options": asdict(options)}
        self._process = subprocess.Popen(
            [
                sys.executable,
                "-P",
                "-c",
                _BOOTSTRAP,
                json.dumps(job),
                str(Path(__file__).parent),
                str(Path(__file__).parents[1]),
            ],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=os.environ | _ENVIRONMENT,
        )
        assert self._process.stdout is not None
        self._pipe = self._process.stdout

    def __enter__(self) -> IsolatedReader:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop the process, whether or not it has finished."""
        self._process.kill()
        self._process.wait()
        with suppress(OSError):
            self._pipe.close()

    def messages(self) -> Iterator[tuple[bytes, bytearray]]:
        """Yield the kind and content of each message; see `formats.parser_process`.

        Raises:
            FormatError: the process reports an error, ends early, or sends nothing for `TIMEOUT_S`.
        """
        while True:
            kind, length = MESSAGE.unpack(self._read(MESSAGE.size))
            content = self._read(length)
            if kind == b"X":
                raise FormatError(content.decode())
            if kind == b"Z":
                return
            if kind != b"W":
                yield kind, content

    def _read(self, length: int) -> bytearray:
        content = bytearray(length)
        view: Any = memoryview(content)
        while view:
            if not select.select([self._pipe], [], [], TIMEOUT_S)[0]:
                raise FormatError(f"{self._path} sent no data for {TIMEOUT_S:.0f} s. {DAMAGED}")
            got = os.readv(self._pipe.fileno(), [view])
            if not got:
                raise self._exit_error()
            view = view[got:]
        return content

    def _exit_error(self) -> FormatError:
        code = self._process.wait()
        if code == -signal.SIGKILL:
            return FormatError(f"{self._path} {TOO_LARGE}")
        if code == -signal.SIGABRT:  # Rust and C++ abort on a failed allocation or assertion
            return FormatError(f"{self._path} {TOO_LARGE_OR_ABORTED}")
        return FormatError(f"{self._path} crashed its parser (exit status {code}). {DAMAGED}")
