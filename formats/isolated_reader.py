"""A file is parsed in a process of its own, so that a broken one cannot take ours with it.

The libraries that decode are written in C, C++ and Rust: a broken file may make them run out of
memory, stop the process or never come back. There, memory is limited; here, whatever happens to
it becomes a sentence. On a second core, parsing costs nothing besides.
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
from pathlib import Path
from typing import Any

from formats.columns import Options
from formats.errors import FormatError
from formats.parser_process import DAMAGED, MESSAGE, TOO_LARGE, TOO_LARGE_OR_LOST

QUIET_S = 60.0
"""How long a message may be awaited (assumed: a slow disk and a busy machine) [s]."""

_BOOT = (
    "import sys, types; package = types.ModuleType('formats'); package.__path__ = [sys.argv[2]]; "
    "sys.modules['formats'] = package; sys.path.append(sys.argv[3]); "
    "from formats.parser_process import main; main()"
)
"""Imports the worker without the package's `__init__`, which imports the bench."""

_ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "RUST_BACKTRACE": "0",
    "MALLOC_ARENA_MAX": "2",
}


class Guard:
    """A running worker and the messages that come from it. Use as a context manager."""

    def __init__(self, path: Path, name: str, options: Options) -> None:
        """Start parsing `path` as the format `name`."""
        self._path = path
        job = {"path": str(path), "format": name, "size": options.size}
        self._process = subprocess.Popen(
            [
                sys.executable,
                "-P",
                "-c",
                _BOOT,
                json.dumps(job | {"time_unit": options.time_unit}),
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

    def __enter__(self) -> Guard:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop the worker, wherever it is."""
        self._process.kill()
        self._process.wait()
        with suppress(OSError):
            self._pipe.close()

    def messages(self) -> Iterator[tuple[bytes, bytearray]]:
        """Kind and content of each message up to the end.

        Raises:
            FormatError: the worker complains, dies or says nothing for `QUIET_S`.
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
            if not select.select([self._pipe], [], [], QUIET_S)[0]:
                raise FormatError(f"{self._path} gave nothing for {QUIET_S:.0f} s; {DAMAGED}")
            got = os.readv(self._pipe.fileno(), [view])
            if not got:
                raise self._death()
            view = view[got:]
        return content

    def _death(self) -> FormatError:
        code = self._process.wait()
        if code == -signal.SIGKILL:
            return FormatError(f"{self._path} {TOO_LARGE}")
        if code == -signal.SIGABRT:  # how Rust and C++ end, out of memory or at a loss
            return FormatError(f"{self._path} {TOO_LARGE_OR_LOST}")
        return FormatError(f"{self._path} stopped its reader (code {code}); {DAMAGED}")
