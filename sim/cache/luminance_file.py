"""File of a sequence's luminance: each sample as its exact change from the one before.

A record has a head (lengths of tags and body, time, rectangle, checksum) and a body. The body holds
what changed in the rectangle's pixels, as 32-bit codes packed by `sim.cache.packing`, with deflated
tags. Each checksum continues the one before, and the first starts from the sequence's key. A record
that is damaged, misplaced or from another sequence is therefore detected before it is used.
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

from sim.cache.packing import add_change, pack_change, tags_shape
from sim.geometry.rectangles import Rectangle

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]
U32 = npt.NDArray[np.uint32]

DEFLATE_LEVEL = 1
"""Level of deflation: the fastest. Tags make up only a twentieth of a file (measured)."""
_HEAD = struct.Struct("<2Iq4i")
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
        codes = _codes(sample)
        if self._before is None:
            self._before = np.zeros_like(codes)
        x0, y0, x1, y1 = sample.changed
        tags, data = pack_change(codes[:, y0:y1, x0:x1], self._before[:, y0:y1, x0:x1])
        deflated = zlib.compress(tags.data, DEFLATE_LEVEL)
        body = deflated + data.tobytes()
        head = _HEAD.pack(len(deflated), len(body), sample.t_us, *sample.changed)
        self._checksum = zlib.crc32(body, zlib.crc32(head, self._checksum))
        record = head + _CHECKSUM.pack(self._checksum) + body
        self._file.write(record)
        self.written += len(record)

    def write_blob(self, blob: bytes) -> None:
        """Write data other than luminance, as the only content of the file.

        Raises:
            OSError: the file cannot be written to.
        """
        self._checksum = zlib.crc32(blob, self._checksum)
        self.written += self._file.write(_CHECKSUM.pack(self._checksum) + blob)


class PartialFile:
    """Cache file being written, under a temporary name and locked as long as its writer lives."""

    def __init__(self, folder: Path, key: str) -> None:
        """Create the file.

        Args:
            folder: folder of the cache.
            key: key of the entry.

        Raises:
            OSError: the file cannot be created.
        """
        descriptor, name = tempfile.mkstemp(dir=folder, prefix=f"{key}.", suffix=".part")
        self.key, self._path, self._file = key, Path(name), os.fdopen(descriptor, "wb")
        fcntl.flock(self._file, fcntl.LOCK_EX)
        self.writer = LuminanceWriter(self._file, key)

    def complete(self, path: Path) -> None:
        """Close the file and give it its final name."""
        self._file.flush()
        self._path.replace(path)
        self._file.close()

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
    file: BinaryIO, key: str, shape: tuple[int, int], count: int
) -> Iterator[LuminanceSample]:
    """Read a file that `LuminanceWriter` wrote.

    Args:
        file: file open for reading, at its start.
        key: key of the sequence.
        shape: height and width of the image.
        count: number of samples that the file must hold.

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
        deflated, length, t_us, *rectangle = _HEAD.unpack_from(head)
        if length > left:
            raise DamagedError
        body = file.read(length)
        left -= length
        checksum = zlib.crc32(body, zlib.crc32(head[: _HEAD.size], checksum))
        if _CHECKSUM.unpack_from(head, _HEAD.size)[0] != checksum:
            raise DamagedError
        _add(codes, memoryview(body), deflated, tuple(rectangle))
        luminance, bodies = codes.copy()
        yield LuminanceSample(
            t_us, luminance.view(np.float32), bodies.view(np.int32), tuple(rectangle)
        )


def _codes(sample: LuminanceSample) -> U32:
    """Return luminance and body numbers as 32-bit codes, (2, height, width)."""
    luminance = np.ascontiguousarray(sample.luminance, np.float32).view(np.uint32)
    return np.stack([luminance, np.ascontiguousarray(sample.body, np.int32).view(np.uint32)])


def _add(codes: U32, body: memoryview, deflated: int, rectangle: Rectangle) -> None:
    """Add the changes of a record's body to (2, height, width) codes, in place."""
    x0, y0, x1, y1 = rectangle
    part = codes[:, y0:y1, x0:x1]
    try:
        tags = np.frombuffer(zlib.decompress(body[:deflated]), np.uint8)
        add_change(part, tags.reshape(tags_shape(part)), np.frombuffer(body[deflated:], np.uint8))
    except (zlib.error, ValueError) as error:
        raise DamagedError from error
