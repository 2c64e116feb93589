"""Pack the changes between two arrays of 32-bit codes into few bytes, without loss.

A change is folded, so that small changes of either sign become small numbers. It takes zero, two,
three or four bytes; a tag of two bits gives the number (after Lemire, Kurz and Rupp 2018, Stream
VByte). Of each row, only the columns from the first change to the last are stored: the number of
bytes of tags, the place of the first one, the tags, and the changes. Deflation does not shrink the
changes, because the last bits of luminance are noise.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined

U8 = npt.NDArray[np.uint8]
U32 = npt.NDArray[np.uint32]

_NUMBER_BYTES = 3
"""Maximum number of bytes of a number before a row's tags, of seven bits each."""


def max_bytes(codes: U32) -> int:
    """Return the maximum number of bytes of packed changes of (rows, columns) codes."""
    rows, columns = codes.shape
    return int(rows * (2 * _NUMBER_BYTES + -(-columns // 4) + 4 * columns))


@compiled
def pack_change(now: U32, before: U32, packed: U8, start: int) -> int:
    """Pack the changes from `before` to `now`, and set `before` to `now`.

    Args:
        now: (rows, columns) codes of a sample; fewer than 2²¹ columns.
        before: codes of the previous sample, of the same shape; overwritten.
        packed: bytes to write to.
        start: index of the first one; at least `max_bytes(now)` bytes must follow.

    Returns:
        Index after the last one written.
    """
    end = start
    for row in range(len(now)):
        first, last = _changed_fours(now[row], before[row])
        end = _put_number(packed, end, last - first)
        if first == last:
            continue
        tags = _put_number(packed, end, first)
        end = tags + last - first
        for four in range(first, last):
            tag_byte = 0
            for column in range(4 * four, min(4 * four + 4, now.shape[1])):
                code = now[row, column]
                if code == before[row, column]:
                    continue
                change = np.int64(np.int32(code - before[row, column]))
                before[row, column] = code
                folded = 2 * change if change >= 0 else -2 * change - 1
                tag = 1 + int(folded >= 1 << 16) + int(folded >= 1 << 24)
                tag_byte |= tag << 2 * (column % 4)
                for k in range(1 + tag):
                    packed[np.uintp(end + k)] = np.uint8(folded >> 8 * k)
                end += 1 + tag
            packed[np.uintp(tags + four - first)] = np.uint8(tag_byte)
    return end


@compiled
def add_change(codes: U32, packed: U8, start: int) -> int:
    """Add packed changes to codes, in place.

    Args:
        codes: (rows, columns) codes of the previous sample; become those of the sample.
        packed: bytes that `pack_change` wrote for codes of this shape.
        start: index of the first one.

    Returns:
        Index after the last one read; -1 if the bytes are not packed changes of this shape. The
        codes are then undefined.
    """
    rows, columns = codes.shape
    size, at = len(packed), start
    for row in range(rows):
        at, count = _get_number(packed, at)
        if count == 0:
            continue
        tags, first = _get_number(packed, at)
        at = tags + count
        if 4 * (first + count) > columns + 3 or at > size:
            return -1
        for k in range(count):
            left, column = int(packed[np.uintp(tags + k)]), 4 * (first + k)
            while left:
                tag = left & 3
                if tag:
                    if column >= columns or at + tag >= size:
                        return -1
                    folded = np.int64(0)
                    for i in range(1 + tag):
                        folded |= np.int64(packed[np.uintp(at + i)]) << 8 * i
                    at += 1 + tag
                    change = -(folded + 1 >> 1) if folded & 1 else folded >> 1
                    codes[row, column] += np.uint32(change)
                left, column = left >> 2, column + 1
    return at if at <= size else -1


@inlined
def _changed_fours(now: U32, before: U32) -> tuple[int, int]:
    """Return the first group of four columns that changed and that after the last; 0, 0 if none."""
    different = np.uint32(0)
    for column in range(len(now)):  # without a branch, many columns are compared at once
        different |= now[column] ^ before[column]
    if different == 0:
        return 0, 0
    first, last = 0, len(now) - 1
    while now[first] == before[first]:
        first += 1
    while now[last] == before[last]:
        last -= 1
    return first // 4, last // 4 + 1


@inlined
def _put_number(packed: U8, at: int, number: int) -> int:
    """Write a number, seven bits a byte and the lowest first; return the index after it."""
    while number >= 128:
        packed[at] = np.uint8(number & 127 | 128)
        at, number = at + 1, number >> 7
    packed[at] = np.uint8(number)
    return at + 1


@inlined
def _get_number(packed: U8, at: int) -> tuple[int, int]:
    """Read a number; return the index after it, which is beyond the end if it is cut, and it."""
    number = 0
    for k in range(_NUMBER_BYTES):
        byte = int(packed[at]) if at < len(packed) else 0
        at += 1
        number |= (byte & 127) << 7 * k
        if byte < 128:
            break
    return at, number
