"""Pack the changes between two arrays of 32-bit codes into few bytes, without loss.

A change is folded, so that small changes of either sign become small numbers. It takes zero, two,
three or four bytes; a tag of two bits gives the number. Tags and bytes are stored separately (after
Lemire, Kurz and Rupp 2018, Stream VByte). The last bits of luminance are noise, which deflation
cannot shrink. Only the tags are deflated, since most of them are 0.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled

U8 = npt.NDArray[np.uint8]
U32 = npt.NDArray[np.uint32]


def tags_shape(codes: U32) -> tuple[int, int, int]:
    """Return the shape of the tags of (planes, rows, columns) codes.

    A byte holds four tags. Each row starts on a byte.
    """
    return codes.shape[0], codes.shape[1], -(-codes.shape[2] // 4)


def pack_change(now: U32, before: U32) -> tuple[U8, U8]:
    """Pack the changes from `before` to `now`, and set `before` to `now`.

    Args:
        now: (planes, rows, columns) codes of a sample.
        before: codes of the previous sample, of the same shape; overwritten.

    Returns:
        Tags, of the shape `tags_shape(now)`; and (n,) bytes.
    """
    tags, data = np.zeros(tags_shape(now), np.uint8), np.empty(4 * now.size, np.uint8)
    return tags, data[: _pack(now, before, tags, data)]


def add_change(codes: U32, tags: U8, data: U8) -> None:
    """Add packed changes to codes, in place.

    Args:
        codes: (planes, rows, columns) codes of the previous sample; become those of the sample.
        tags: tags, of the shape `tags_shape(codes)`.
        data: (n,) bytes.

    Raises:
        ValueError: the tags do not match the number of bytes or the shape of the codes.
    """
    if tags.shape != tags_shape(codes) or _length(tags) != len(data):
        raise ValueError(
            f"tags of shape {tags.shape} do not match {len(data)} bytes and codes of shape "
            f"{codes.shape}. Allowed are tags and bytes that were packed from codes of this shape. "
            "Pass both as `pack_change` returned them."
        )
    _add(codes, tags, data)


_COUNTS = np.array(
    [sum((0, 2, 3, 4)[tags >> shift & 3] for shift in (0, 2, 4, 6)) for tags in range(256)],
    np.uint8,
)
"""Number of bytes of the four changes that each value of a byte of tags stands for."""


@compiled
def _length(tags: U8) -> int:
    """Return the number of bytes of the changes with these tags."""
    total = 0
    for four in tags.flat:
        total += int(_COUNTS[four])
    return total


@compiled
def _pack(now: U32, before: U32, tags: U8, data: U8) -> int:
    """Fill tags, which must be 0, and bytes. Return the number of bytes."""
    planes, rows, columns = now.shape
    end = 0
    for plane in range(planes):
        for row in range(rows):
            for column in range(columns):
                code = now[plane, row, column]
                if code == before[plane, row, column]:
                    continue
                change = np.int64(np.int32(code - before[plane, row, column]))
                before[plane, row, column] = code
                folded = 2 * change if change >= 0 else -2 * change - 1
                tag = 1 + int(folded >= 1 << 16) + int(folded >= 1 << 24)
                tags[plane, row, column // 4] |= np.uint8(tag << 2 * (column % 4))
                for k in range(1 + tag):
                    data[end + k] = np.uint8(folded >> 8 * k)
                end += 1 + tag
    return end


@compiled
def _add(codes: U32, tags: U8, data: U8) -> None:
    """Add packed changes without checks; tags and bytes must belong together."""
    planes, rows, columns = codes.shape
    at = 0
    for plane in range(planes):
        for row in range(rows):
            for four in range(tags.shape[2]):
                left, column = tags[plane, row, four], 4 * four
                while left > 0 and column < columns:
                    tag = left & 3
                    if tag > 0:
                        folded = np.int64(data[at]) | np.int64(data[at + 1]) << 8
                        if tag > 1:
                            folded |= np.int64(data[at + 2]) << 16
                        if tag > 2:
                            folded |= np.int64(data[at + 3]) << 24
                        at += 1 + tag
                        change = -(folded + 1 >> 1) if folded & 1 else folded >> 1
                        codes[plane, row, column] += np.uint32(change)
                    left, column = left >> 2, column + 1
