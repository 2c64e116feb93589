"""A folder that keeps light, so that a sweep over sensors draws each sequence once.

An entry is written under another name while it is drawn, and moved into place when it is whole; one
that its writer could not finish is known by its lock, which ended with the writer. A reader has the
file open, so that others may drop or replace it meanwhile. Where an entry proves damaged, it is
dropped and the rest is drawn. Nothing that fails here ends a run, which goes on without.
"""

from __future__ import annotations

import fcntl
import os
import re
import tempfile
import warnings
from collections.abc import Callable, Generator, Iterator
from contextlib import closing, contextmanager, suppress
from functools import partial
from itertools import islice
from pathlib import Path

from sim.cache.luminance_file import DamagedError, Light, LuminanceWriter, read_luminance, unsealed
from sim.errors import SimError

LIMIT_BYTES = 4_000_000_000
"""A hundred sequences like the paper's, which take 40 MB each (measured); the limit is assumed."""
LOCK = "flybench.lock"
_IS_ENTRY = re.compile(r"[0-9a-f]{64}\.light")
_IS_PART = re.compile(r"[0-9a-f]{64}\.\w+\.part")

LuminanceStream = Generator[Light, None, None]


class LuminanceCache:
    """Keeps the light of the sequences used last, by their keys. Not for several threads at once.

    Any number of processes may use one folder; files in it that are not entries are left alone.

    Attributes:
        folder: where entries lie; made when the first is written.
        limit_bytes: how much they may take together, those not counted that are being written.
        found: how many samples were read so far.
        drawn: how many were drawn.
        keeps: whether what was drawn last was kept, too.
    """

    def __init__(
        self,
        folder: Path,
        *,
        limit_bytes: int = LIMIT_BYTES,
        warn: Callable[[str], None] = warnings.warn,
    ) -> None:
        """Name a folder; nothing is read or written yet.

        Args:
            folder: where entries lie.
            limit_bytes: how much they may take together; what was used longest ago goes first.
            warn: told, in a sentence and once, that light cannot be kept, and why.

        Raises:
            SimError: a limit below 0.
        """
        if limit_bytes < 0:
            raise SimError(
                f"limit_bytes is {limit_bytes}; allowed is 0 or more; leave it out for "
                f"{LIMIT_BYTES:,}"
            )
        self.folder, self.limit_bytes = folder, limit_bytes
        self.found = self.drawn = 0
        self.keeps = False
        self._warn, self._warned, self._writes = warn, False, True

    def light(
        self, key: str, shape: tuple[int, int], count: int, draw: Callable[[], LuminanceStream]
    ) -> LuminanceStream:
        """Read a sequence's light, or draw it and keep it.

        Args:
            key: 64 hexadecimal digits that stand for all that determines the light.
            shape: height and width of the image.
            count: how many samples there are.
            draw: gives all of them.

        Yields:
            Samples, read as they were drawn, bit for bit.
        """
        known = 0
        for light in self._read(key, shape, count):
            known += 1
            self.found += 1
            yield light
        if known == count:
            return
        with closing(draw()) as drawn, closing(self._keep(key, count, drawn)) as lights:
            for light in islice(lights, known, None):
                self.drawn += 1
                yield light

    def kept(self, key: str, make: Callable[[], bytes]) -> bytes:
        """Read what goes with a sequence's light, such as pictures of it, or make and keep it.

        Args:
            key: 64 hexadecimal digits that stand for all that determines it.
            make: gives it.
        """
        with suppress(DamagedError, OSError):
            path = self._path(key)
            body = unsealed(path.read_bytes(), key)
            os.utime(path)
            return body
        body = make()
        part = self._begin(key)
        if part is not None:
            self._append(part, lambda: part.writer.seal(body), last=True)
        return body

    def _read(self, key: str, shape: tuple[int, int], count: int) -> LuminanceStream:
        """Samples from the first to the last before any damage; none without an entry."""
        path = self._path(key)
        try:
            with path.open("rb") as file:
                with suppress(OSError):
                    os.utime(file.fileno())
                yield from read_luminance(file, key, shape, count)
        except DamagedError:
            with suppress(OSError):
                path.unlink()
        except OSError:
            return

    def _keep(self, key: str, count: int, drawn: LuminanceStream) -> LuminanceStream:
        """Pass samples on and write them; with the last, the entry takes its place."""
        part = self._begin(key)
        try:
            for number, light in enumerate(drawn, start=1):
                if part is not None:
                    write = partial(part.writer.write, light)
                    part = self._append(part, write, last=number == count)
                self.keeps = part is not None or (self.keeps and number == count)
                yield light
        finally:
            if part is not None:
                part.drop()

    def _begin(self, key: str) -> _Part | None:
        if not self._writes:
            return None
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with self._locked():
                self._sweep()
                return _Part(self.folder, key)
        except OSError as error:
            self._stop(error)
            return None

    def _append(self, part: _Part, write: Callable[[], None], *, last: bool) -> _Part | None:
        """Let a part be written to; gives None once nothing more is to be written."""
        try:
            write()
            if part.writer.written > self.limit_bytes:
                part.drop()
                self._say(self._too_large())
                return None
            if last:
                with self._locked():
                    self._make_room(part.writer.written)
                    part.settle(self._path(part.key))
        except OSError as error:
            part.drop()
            self._stop(error)
            return None
        return None if last else part

    def _too_large(self) -> str:
        return (
            f"the light of a sequence takes more than the {self.limit_bytes / 1e9:g} GB that are "
            f"allowed in {self.folder}, so it is not kept; allow more to have it kept"
        )

    def _stop(self, error: OSError) -> None:
        self._writes = False
        self._say(
            f"light cannot be kept in {self.folder} ({error.strerror}), so it is drawn each time; "
            "choose another folder, make room, or use no cache"
        )

    def _say(self, sentence: str) -> None:
        if not self._warned:
            self._warned = True
            self._warn(sentence)

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.light"

    def _files(self, pattern: re.Pattern[str]) -> list[Path]:
        return [path for path in self.folder.iterdir() if pattern.fullmatch(path.name)]

    @contextmanager
    def _locked(self) -> Iterator[None]:
        """One process at a time."""
        with (self.folder / LOCK).open("wb") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield

    def _sweep(self) -> None:
        """Remove what writers have begun who are no more."""
        for path in self._files(_IS_PART):
            with suppress(OSError), path.open("rb") as file:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                path.unlink()

    def _make_room(self, size: int) -> None:
        """Remove the entries used longest ago, until one of `size` bytes has room."""
        entries = []
        for path in self._files(_IS_ENTRY):
            with suppress(FileNotFoundError):
                found = path.stat()
                entries.append((found.st_mtime_ns, found.st_size, path))
        spare = self.limit_bytes - size - sum(taken for _, taken, _ in entries)
        for _, taken, path in sorted(entries):
            if spare >= 0:
                return
            path.unlink(missing_ok=True)
            spare += taken


class _Part:
    """An entry that is being written: under another name, locked as long as its writer lives."""

    def __init__(self, folder: Path, key: str) -> None:
        descriptor, name = tempfile.mkstemp(dir=folder, prefix=f"{key}.", suffix=".part")
        self.key, self._path, self._file = key, Path(name), os.fdopen(descriptor, "wb")
        fcntl.flock(self._file, fcntl.LOCK_EX)
        self.writer = LuminanceWriter(self._file, key)

    def settle(self, path: Path) -> None:
        """Take the place of a whole entry."""
        self._file.flush()
        self._path.replace(path)
        self._file.close()

    def drop(self) -> None:
        """Leave nothing behind."""
        with suppress(OSError):
            self._path.unlink()
        with suppress(OSError):
            self._file.close()
