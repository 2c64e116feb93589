"""The light of a sequence in one file: each sample as what it changes in the one before, exactly.

A record is a head (lengths of tags and of both, time, rectangle, checksum) and a body: what changed
of the rectangle's pixels, taken as 32-bit codes, as `sim.cache.packing` has it, its tags deflated.
Every checksum goes on from the one before and the first from the sequence's key, so that a record
that is damaged, misplaced or of another sequence is known before any of its light is used.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from sim.cache.packing import add_change, pack_change, tags_shape
from sim.geometry.rectangles import Rectangle

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]
U32 = npt.NDArray[np.uint32]

LEVEL = 1
"""Of deflation: the fastest; of a file, tags are but a twentieth (measured)."""
_HEAD = struct.Struct("<2Iq4i")
_CHECK = struct.Struct("<I")


class DamagedError(Exception):
    """A file is not what was written."""


@dataclass(frozen=True, eq=False)
class Light:
    """What the camera sees at one instant.

    Attributes:
        t_us: time since the start of the sequence [µs].
        luminance: (height, width) float32 [cd/m²].
        body: (height, width) int32, the rigid body that each pixel's middle shows; see
            `sim.raster.visibility.Visible`.
        changed: x0, y0, x1, y1 of a rectangle outside of which both are as at the sample before,
            half-open [px]; of the first sample, the whole image.
    """

    t_us: int
    luminance: F32
    body: I32
    changed: Rectangle


class LuminanceWriter:
    """Writes samples to a file, one after the other."""

    def __init__(self, file: BinaryIO, key: str) -> None:
        """Begin.

        Args:
            file: open for writing, empty.
            key: of the sequence.
        """
        self._file, self._check = file, zlib.crc32(key.encode())
        self._before: U32 | None = None
        self.written = 0
        """Bytes so far."""

    def write(self, light: Light) -> None:
        """Append a sample.

        Raises:
            OSError: the file cannot take it.
        """
        codes = _codes(light)
        if self._before is None:
            self._before = np.zeros_like(codes)
        x0, y0, x1, y1 = light.changed
        tags, data = pack_change(codes[:, y0:y1, x0:x1], self._before[:, y0:y1, x0:x1])
        deflated = zlib.compress(tags.data, LEVEL)
        body = deflated + data.tobytes()
        head = _HEAD.pack(len(deflated), len(body), light.t_us, *light.changed)
        self._check = zlib.crc32(body, zlib.crc32(head, self._check))
        record = head + _CHECK.pack(self._check) + body
        self._file.write(record)
        self.written += len(record)

    def seal(self, body: bytes) -> None:
        """Write something else that goes with light, as the only thing in its file.

        Raises:
            OSError: the file cannot take it.
        """
        self._check = zlib.crc32(body, self._check)
        self.written += self._file.write(_CHECK.pack(self._check) + body)


def unsealed(content: bytes, key: str) -> bytes:
    """What `LuminanceWriter.seal` wrote, from the whole content of its file.

    Raises:
        DamagedError: the file is not what was written.
    """
    body = content[_CHECK.size :]
    check = zlib.crc32(body, zlib.crc32(key.encode()))
    if content[: _CHECK.size] != _CHECK.pack(check):
        raise DamagedError
    return body


def read_luminance(file: BinaryIO, key: str, shape: tuple[int, int], count: int) -> Iterator[Light]:
    """Read a file that `LuminanceWriter` wrote.

    Args:
        file: open for reading, at its start.
        key: of the sequence.
        shape: height and width of its image.
        count: how many samples it must hold.

    Yields:
        Samples; each owns its arrays.

    Raises:
        DamagedError: the file is not what was written; what came before is right.
        OSError: it cannot be read.
    """
    check, codes = zlib.crc32(key.encode()), np.zeros((2, *shape), np.uint32)
    left = os.fstat(file.fileno()).st_size
    for _ in range(count):
        head = file.read(_HEAD.size + _CHECK.size)
        left -= len(head)
        if len(head) < _HEAD.size + _CHECK.size:
            raise DamagedError
        deflated, length, t_us, *rectangle = _HEAD.unpack_from(head)
        if length > left:
            raise DamagedError
        body = file.read(length)
        left -= length
        check = zlib.crc32(body, zlib.crc32(head[: _HEAD.size], check))
        if _CHECK.unpack_from(head, _HEAD.size)[0] != check:
            raise DamagedError
        _add(codes, memoryview(body), deflated, tuple(rectangle))
        luminance, shown = codes.copy()
        yield Light(t_us, luminance.view(np.float32), shown.view(np.int32), tuple(rectangle))


def _codes(light: Light) -> U32:
    """(2, height, width) luminance and bodies, bit for bit."""
    luminance = np.ascontiguousarray(light.luminance, np.float32).view(np.uint32)
    return np.stack([luminance, np.ascontiguousarray(light.body, np.int32).view(np.uint32)])


def _add(codes: U32, body: memoryview, deflated: int, rectangle: Rectangle) -> None:
    """Add what changed to (2, height, width) codes, in place."""
    x0, y0, x1, y1 = rectangle
    part = codes[:, y0:y1, x0:x1]
    try:
        tags = np.frombuffer(zlib.decompress(body[:deflated]), np.uint8)
        add_change(part, tags.reshape(tags_shape(part)), np.frombuffer(body[deflated:], np.uint8))
    except (zlib.error, ValueError) as error:
        raise DamagedError from error
