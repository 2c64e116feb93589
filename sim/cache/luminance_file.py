"""File of a sequence's luminance: each sample as its exact change from the one before.

A record has a head (length of the body, time, rectangle, checksum) and a body. The body holds what
changed in the rectangle's pixels, first of luminance and then of bodies, as 32-bit codes packed by
`sim.cache.packing`. Each checksum continues the one before, and the first starts from the
sequence's key. A record that is damaged, misplaced or from another sequence is therefore detected
before it is used.
"""

from __future__ import annotations

import fcntl
import os
import struct
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from flybench.files import open_regular
from sim.cache.packing import add_change, max_bytes, pack_change
from sim.geometry.rectangles import Rectangle

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]
U8 = npt.NDArray[np.uint8]
U32 = npt.NDArray[np.uint32]

_HEAD = struct.Struct("<Iq4i")
_CHECKSUM = struct.Struct("<I")


class DamagedError(Exception):
    """The content of a file is not what was written."""


@dataclass(frozen=True, eq=False)
class LuminanceSample:
    """What the camera sees at one instant.

    Attributes:
        t_us: time since the start of the sequence [µs].
        luminance: (height, width) float32 [cd/m²].
        body: (height, width) int32, the rigid body at each pixel centre; see
            `sim.raster.visibility.VisibilityMap`.
        changed: x0, y0, x1, y1 of a rectangle outside which luminance and body equal those of the
            sample before, half-open [px]. For the first sample it is the whole image.
    """

    t_us: int
    luminance: F32
    body: I32
    changed: Rectangle


class LuminanceWriter:
    """Writes samples to a file, one after another."""

    def __init__(self, file: BinaryIO, key: str) -> None:
        """Start with an empty file.

        Args:
            file: empty file, open for writing.
            key: key of the sequence.
        """
        self._file, self._checksum = file, zlib.crc32(key.encode())
        self._before: U32 | None = None
        self.written = 0
        """Number of bytes written so far."""

    def write(self, sample: LuminanceSample) -> None:
        """Append a sample.

        Raises:
            OSError: the file cannot be written to.
        """
        planes = _codes(sample)
        if self._before is None:
            self._before = np.zeros((2, *planes[0].shape), np.uint32)
        x0, y0, x1, y1 = sample.changed
        changed = [
            (plane[y0:y1, x0:x1], old[y0:y1, x0:x1])
            for plane, old in zip(planes, self._before, strict=True)
        ]
        packed, end = np.empty(2 * max_bytes(changed[0][0]), np.uint8), 0
        for now, before in changed:
            end = pack_change(now, before, packed, end)
        body = packed[:end].data
        head = _HEAD.pack(end, sample.t_us, *sample.changed)
        self._checksum = zlib.crc32(body, zlib.crc32(head, self._checksum))
        self._file.write(head + _CHECKSUM.pack(self._checksum))
        self._file.write(body)
        self.written += _HEAD.size + _CHECKSUM.size + end

    def continue_from(self, codes: U32, checksum: int, size: int) -> None:
        """Continue a file after a record that was read from it.

        Args:
            codes: (2, height, width) codes of the record's sample.
            checksum: checksum of the record.
            size: number of bytes up to the end of the record.
        """
        self._before, self._checksum, self.written = codes.copy(), checksum, size

    def write_blob(self, blob: bytes) -> None:
        """Write data other than luminance, as the only content of the file.

        Raises:
            OSError: the file cannot be written to.
        """
        self._checksum = zlib.crc32(blob, self._checksum)
        self.written += self._file.write(_CHECKSUM.pack(self._checksum) + blob)


class PartialFile:
    """Cache file being written, under a temporary name and locked as long as its writer lives."""

    def __init__(self, path: Path, key: str, file: BinaryIO) -> None:
        """Lock the file.

        Args:
            path: path of the file.
            key: key of the entry.
            file: the file, open for reading and writing, at its start.

        Raises:
            BlockingIOError: its writer lives.
            FileNotFoundError: its writer has just completed or deleted it.
        """
        self.key, self._path, self._file = key, path, file
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if not os.path.samestat(os.fstat(file.fileno()), path.stat()):
            raise FileNotFoundError(path)
        self.writer = LuminanceWriter(file, key)

    @classmethod
    def create(cls, folder: Path, key: str) -> PartialFile:
        """Create a file in the folder of the cache.

        Raises:
            OSError: the file cannot be created.
        """
        descriptor, name = tempfile.mkstemp(dir=folder, prefix=f"{key}.", suffix=".part")
        return cls(Path(name), key, os.fdopen(descriptor, "w+b"))

    @classmethod
    def adopt(cls, path: Path, key: str) -> PartialFile:
        """Take over the file of a writer that has ended.

        Raises:
            OSError: its writer lives or has just completed or deleted it, or it cannot be opened.
        """
        file = open_regular(path, "r+b")
        try:
            return cls(path, key, file)
        except OSError:
            file.close()
            raise

    def samples(self, shape: tuple[int, int], count: int) -> Iterator[LuminanceSample]:
        """Yield the undamaged samples in the file, and drop what follows them.

        Raises:
            OSError: the file cannot be read or written.
        """
        with suppress(DamagedError):
            yield from read_luminance(self._file, self.key, shape, count, self.writer)
        self._file.seek(self.writer.written)
        self._file.truncate()

    def complete(self, path: Path) -> None:
        """Close the file and give it its final name."""
        self._file.flush()
        self._path.replace(path)
        self._file.close()

    def leave(self) -> None:
        """Close the file, so that another writer can adopt it; delete it if it is empty."""
        with suppress(OSError):
            self._file.flush()
            if os.fstat(self._file.fileno()).st_size:
                self._file.close()
        if not self._file.closed:
            self.discard()

    def discard(self) -> None:
        """Delete the file."""
        with suppress(OSError):
            self._path.unlink()
        with suppress(OSError):
            self._file.close()


def read_blob(content: bytes, key: str) -> bytes:
    """Return what `LuminanceWriter.write_blob` wrote.

    Args:
        content: whole content of the file.
        key: key that the file was written with.

    Raises:
        DamagedError: the content is not what was written.
    """
    blob = content[_CHECKSUM.size :]
    checksum = zlib.crc32(blob, zlib.crc32(key.encode()))
    if content[: _CHECKSUM.size] != _CHECKSUM.pack(checksum):
        raise DamagedError
    return blob


def read_luminance(
    file: BinaryIO,
    key: str,
    shape: tuple[int, int],
    count: int,
    writer: LuminanceWriter | None = None,
) -> Iterator[LuminanceSample]:
    """Read a file that `LuminanceWriter` wrote.

    Args:
        file: file open for reading, at its start.
        key: key of the sequence.
        shape: height and width of the image.
        count: number of samples that the file must hold.
        writer: writer that is to continue the file after the last sample that was read.

    Yields:
        Samples; each owns its arrays.

    Raises:
        DamagedError: the content is not what was written. The samples before it are correct.
        OSError: the file cannot be read.
    """
    checksum, codes = zlib.crc32(key.encode()), np.zeros((2, *shape), np.uint32)
    left = os.fstat(file.fileno()).st_size
    for _ in range(count):
        head = file.read(_HEAD.size + _CHECKSUM.size)
        left -= len(head)
        if len(head) < _HEAD.size + _CHECKSUM.size:
            raise DamagedError
        length, t_us, *rectangle = _HEAD.unpack_from(head)
        if length > left:
            raise DamagedError
        body = file.read(length)
        left -= length
        checksum = zlib.crc32(body, zlib.crc32(head[: _HEAD.size], checksum))
        if _CHECKSUM.unpack_from(head, _HEAD.size)[0] != checksum:
            raise DamagedError
        _add(codes, np.frombuffer(body, np.uint8), tuple(rectangle))
        if writer is not None:
            writer.continue_from(codes, checksum, file.tell())
        luminance, bodies = codes.copy()
        yield LuminanceSample(
            t_us, luminance.view(np.float32), bodies.view(np.int32), tuple(rectangle)
        )


def _codes(sample: LuminanceSample) -> tuple[U32, U32]:
    """Return luminance and body numbers as 32-bit codes, (height, width) each."""
    luminance = np.ascontiguousarray(sample.luminance, np.float32).view(np.uint32)
    return luminance, np.ascontiguousarray(sample.body, np.int32).view(np.uint32)


def _add(codes: U32, packed: U8, rectangle: Rectangle) -> None:
    """Add the changes of a record's body to (2, height, width) codes, in place."""
    x0, y0, x1, y1 = rectangle
    end = 0
    for plane in codes[:, y0:y1, x0:x1]:
        end = add_change(plane, packed, end) if end >= 0 else end
    if end != len(packed):
        raise DamagedError
