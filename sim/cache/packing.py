"""What changes in 32-bit codes, in as few bytes as it needs.

A change is folded, so that small ones of either sign are small numbers, and takes none, two, three
or four bytes, which a tag of two bits says; tags and bytes are kept apart (after Lemire, Kurz and
Rupp 2018, Stream VByte). Light's last bits are noise that no deflation makes smaller; what deflates
is the tags, most of which are 0.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled

U8 = npt.NDArray[np.uint8]
U32 = npt.NDArray[np.uint32]


def tags_shape(codes: U32) -> tuple[int, int, int]:
    """Shape of the tags of (parts, rows, columns) codes: four a byte, each row from a byte on."""
    return codes.shape[0], codes.shape[1], -(-codes.shape[2] // 4)


def pack_change(now: U32, before: U32) -> tuple[U8, U8]:
    """Take down what changed, and let `before` become `now`.

    Args:
        now: (parts, rows, columns) codes.
        before: the same of the sample before; changed.

    Returns:
        Tags of `tags_shape`, and (n,) bytes.
    """
    tags, data = np.zeros(tags_shape(now), np.uint8), np.empty(4 * now.size, np.uint8)
    return tags, data[: _pack(now, before, tags, data)]


def add_change(codes: U32, tags: U8, data: U8) -> None:
    """Add what changed, in place.

    Args:
        codes: (parts, rows, columns) of the sample before; become those of the sample.
        tags: of their `tags_shape`.
        data: (n,) bytes.

    Raises:
        ValueError: these are not the tags of so many bytes, or not of such codes.
    """
    if tags.shape != tags_shape(codes) or _length(tags) != len(data):
        raise ValueError("these are not the tags of so many bytes, or not of such codes")
    _add(codes, tags, data)


_COUNTS = np.array(
    [sum((0, 2, 3, 4)[tags >> shift & 3] for shift in (0, 2, 4, 6)) for tags in range(256)],
    np.uint8,
)
"""How many bytes the four changes take that a byte of tags is for."""


@compiled
def _length(tags: U8) -> int:
    """How many bytes the changes take that have these tags."""
    total = 0
    for four in tags.flat:
        total += int(_COUNTS[four])
    return total


@compiled
def _pack(now: U32, before: U32, tags: U8, data: U8) -> int:
    """Fill tags, which are 0, and bytes; how many bytes."""
    parts, rows, columns = now.shape
    end = 0
    for part in range(parts):
        for row in range(rows):
            for column in range(columns):
                code = now[part, row, column]
                if code == before[part, row, column]:
                    continue
                change = np.int64(np.int32(code - before[part, row, column]))
                before[part, row, column] = code
                folded = 2 * change if change >= 0 else -2 * change - 1
                tag = 1 + int(folded >= 1 << 16) + int(folded >= 1 << 24)
                tags[part, row, column // 4] |= np.uint8(tag << 2 * (column % 4))
                for k in range(1 + tag):
                    data[end + k] = np.uint8(folded >> 8 * k)
                end += 1 + tag
    return end


@compiled
def _add(codes: U32, tags: U8, data: U8) -> None:
    """See `add_change`; tags and bytes must belong together."""
    parts, rows, columns = codes.shape
    at = 0
    for part in range(parts):
        for row in range(rows):
            for four in range(tags.shape[2]):
                left, column = tags[part, row, four], 4 * four
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
                        codes[part, row, column] += np.uint32(change)
                    left, column = left >> 2, column + 1
