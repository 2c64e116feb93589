"""Folder that caches rendered luminance, so that a sweep over sensors renders each sequence once.

An entry is written under a temporary name while it is rendered, and renamed when it is complete.
Its writer holds a lock on it, which is released when the writer ends. A partial entry without a
lock was therefore abandoned, and the next writer of the same entry continues it. A reader keeps the
file open, so that others may delete or replace it meanwhile. Of a damaged entry, the samples before
the damage are kept, and the rest is rendered. No failure of the cache ends a run: the run then goes
on without the cache.
"""

from __future__ import annotations

import fcntl
import os
import re
import warnings
from collections.abc import Callable, Generator, Iterator
from contextlib import closing, contextmanager, suppress
from functools import partial
from itertools import islice
from pathlib import Path

from flybench.files import open_lock, open_regular
from sim.cache.luminance_file import (
    DamagedError,
    LuminanceSample,
    PartialFile,
    read_blob,
    read_luminance,
)
from sim.errors import SimError

LIMIT_BYTES = 4_000_000_000
"""Room for a hundred sequences like the paper's, which take 40 MB each (measured); the limit is
assumed."""
LOCK = "flybench.lock"
_ENTRY_NAME = re.compile(r"[0-9a-f]{64}\.light")
_PARTIAL_NAME = re.compile(r"[0-9a-f]{64}\.\w+\.part")

LuminanceStream = Generator[LuminanceSample, None, None]


class LuminanceCache:
    """Cache of rendered luminance. Not thread-safe; any number of processes may share a folder.

    The least recently used entries are deleted when the folder becomes too large. Files in the
    folder that are not cache entries are left alone.

    Attributes:
        folder: folder of the entries; created when the first one is written.
        limit_bytes: maximum total size of the entries that are not being written.
        read: number of samples read so far.
        rendered: number of samples rendered so far.
        stores: True if the sequence read last is incomplete in the cache and is being stored.
    """

    def __init__(
        self,
        folder: Path,
        *,
        limit_bytes: int = LIMIT_BYTES,
        warn: Callable[[str], None] = warnings.warn,
    ) -> None:
        """Set the folder; nothing is read or written yet.

        Args:
            folder: folder of the entries.
            limit_bytes: maximum total size. The entries used longest ago are deleted first.
            warn: called once, with a message, if luminance cannot be stored.

        Raises:
            SimError: `limit_bytes` is below 0.
        """
        if limit_bytes < 0:
            raise SimError(
                f"limit_bytes is {limit_bytes}. Allowed is 0 or more. Leave it out for the default "
                f"of {LIMIT_BYTES:,}."
            )
        self.folder, self.limit_bytes = folder, limit_bytes
        self.read = self.rendered = 0
        self.stores = False
        self._warn, self._warned, self._writes = warn, False, True

    def samples(
        self,
        key: str,
        shape: tuple[int, int],
        count: int,
        render: Callable[[int], LuminanceStream],
    ) -> LuminanceStream:
        """Read a sequence's luminance, or render and store it.

        Args:
            key: 64 hexadecimal digits, a digest of everything that determines the luminance.
            shape: height and width of the image.
            count: number of samples.
            render: renders the samples from that of a given number on.

        Yields:
            Samples; those read equal those rendered, bit for bit.
        """
        known, self.stores = 0, False
        for sample in self._read(key, shape, count):
            known += 1
            self.read += 1
            yield sample
        if known < count:
            with closing(self._store(key, shape, count, render, known)) as samples:
                yield from islice(samples, known, None)

    def get_or_make(self, key: str, make: Callable[[], bytes]) -> bytes:
        """Read data that accompany a sequence, such as its previews, or make and store them.

        Args:
            key: 64 hexadecimal digits, a digest of everything that determines the data.
            make: makes the data.
        """
        with suppress(DamagedError, OSError):
            path = self._path(key)
            with open_regular(path) as file:
                blob = read_blob(file.read(), key)
            os.utime(path)
            return blob
        blob = make()
        part = self._begin(key, adopt=False)
        if part is not None:
            self._append(part, lambda: part.writer.write_blob(blob), last=True)
        return blob

    def _read(self, key: str, shape: tuple[int, int], count: int) -> LuminanceStream:
        """Read the samples before any damage; none if there is no entry."""
        path = self._path(key)
        try:
            with open_regular(path) as file:
                with suppress(OSError):
                    os.utime(file.fileno())
                yield from read_luminance(file, key, shape, count)
        except DamagedError:  # the samples before the damage are the start of a new entry
            with suppress(OSError):
                path.replace(self.folder / f"{key}.damaged.part")
        except OSError:
            return

    def _store(
        self,
        key: str,
        shape: tuple[int, int],
        count: int,
        render: Callable[[int], LuminanceStream],
        known: int,
    ) -> LuminanceStream:
        """Continue a partial entry, or begin one. The last sample completes it.

        The first `known` samples do not count as read, because they were read before.
        """
        part, number = self._begin(key, adopt=True), 0
        try:
            try:
                # Leave at least the last sample to be rendered, which completes the entry.
                for sample in part.samples(shape, count - 1) if part else ():
                    number += 1
                    self.read += number > known
                    self.stores = True
                    yield sample
            except OSError as error:
                self._stop(error)
                if part is not None:
                    part.discard()
                part = None
            with closing(render(number)) as rendered:
                for sample in rendered:
                    number += 1
                    self.rendered += 1
                    if part is not None:
                        write = partial(part.writer.write, sample)
                        part = self._append(part, write, last=number == count)
                    self.stores = part is not None or (self.stores and number == count)
                    yield sample
        finally:
            if part is not None:
                part.leave()

    def _begin(self, key: str, *, adopt: bool) -> PartialFile | None:
        if not self._writes:
            return None
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with self._locked():
                abandoned = self._abandoned(key)
                adopted = abandoned.pop() if adopt and abandoned else None
                for part in abandoned:
                    part.discard()
                return adopted or PartialFile.create(self.folder, key)
        except OSError as error:
            self._stop(error)
            return None

    def _append(
        self, part: PartialFile, write: Callable[[], None], *, last: bool
    ) -> PartialFile | None:
        """Write to a partial entry; return None when nothing more is to be written."""
        try:
            write()
            if part.writer.written > self.limit_bytes:
                part.discard()
                self._warn_once(self._too_large())
                return None
            if last:
                with self._locked():
                    self._make_room(part.writer.written)
                    part.complete(self._path(part.key))
        except OSError as error:
            part.discard()
            self._stop(error)
            return None
        return None if last else part

    def _too_large(self) -> str:
        return (
            f"the luminance of one sequence takes more than the {self.limit_bytes / 1e9:g} GB "
            f"allowed in {self.folder}, so it is not stored. Raise the limit to store it."
        )

    def _stop(self, error: OSError) -> None:
        self._writes = False
        self._warn_once(
            f"luminance cannot be stored in {self.folder} ({error.strerror}), so it is rendered "
            "each time. Choose another folder, free some space, or switch the cache off."
        )

    def _warn_once(self, message: str) -> None:
        if not self._warned:
            self._warned = True
            self._warn(message)

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.light"

    def _files(self, pattern: re.Pattern[str]) -> list[Path]:
        return [path for path in self.folder.iterdir() if pattern.fullmatch(path.name)]

    @contextmanager
    def _locked(self) -> Iterator[None]:
        """Keep other processes out of the folder."""
        with open_lock(self.folder / LOCK) as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield

    def _abandoned(self, key: str) -> list[PartialFile]:
        """Return the partial files of an entry whose writers have ended, the largest last."""
        found = []
        for path in self._files(_PARTIAL_NAME):
            if path.name.startswith(key):
                with suppress(OSError):
                    found.append((path.stat().st_size, path))
        parts = []
        for _, path in sorted(found):
            with suppress(OSError):
                parts.append(PartialFile.adopt(path, key))
        return parts

    def _make_room(self, size: int) -> None:
        """Delete the entries used longest ago until another of `size` bytes fits."""
        entries = []
        partial_files = [path for path in self._files(_PARTIAL_NAME) if not _is_locked(path)]
        for path in self._files(_ENTRY_NAME) + partial_files:
            with suppress(FileNotFoundError):
                found = path.stat()
                entries.append((found.st_mtime_ns, found.st_size, path))
        spare = self.limit_bytes - size - sum(taken for _, taken, _ in entries)
        for _, taken, path in sorted(entries):
            if spare >= 0:
                return
            path.unlink(missing_ok=True)
            spare += taken


def _is_locked(path: Path) -> bool:
    """Return True if the writer of a partial entry lives."""
    try:
        with open_regular(path) as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return True
    return False
