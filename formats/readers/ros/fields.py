"""Fields of a serialised ROS message, read one after the other.

ROS 1 packs fields without gaps (wiki.ros.org/msg). ROS 2 uses CDR: after 4 bytes that state the
byte order, each number is aligned to its own size (OMG DDS-RTPS 2.2, section 10; CORBA 3.3, part
2, section 9.3).
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from formats.columns import Array

_CDR_HEAD = 4
_CDR_ORDERS = {b"\0\0": ">", b"\0\1": "<"}


class MessageError(ValueError):
    """A message is shorter than it states, or encoded in an unknown way."""


class MessageFields:
    """A position in a message, which moves forward as fields are read.

    Attributes:
        order: byte order, "<" or ">".
        at: position of the next field [bytes].
        is_ros1: True if the message is serialised as in ROS 1.
    """

    def __init__(self, data: bytes, *, is_ros1: bool) -> None:
        self._data, self.is_ros1 = data, is_ros1
        self.order, self.at = "<", 0
        if not is_ros1:
            order = _CDR_ORDERS.get(data[:2])
            if order is None:
                raise MessageError(f"it begins with {data[:4].hex()}, which is not plain CDR")
            self.order, self.at = order, _CDR_HEAD

    def number(self, code: str) -> Any:
        """Return one number of the type `code` of the module struct."""
        size = struct.calcsize(f"={code}")
        if not self.is_ros1:
            self.at += -(self.at - _CDR_HEAD) % size
        (value,) = struct.unpack_from(self.order + code, self.take(size))
        return value

    def take(self, length: int) -> memoryview:
        """Return the next bytes."""
        part = memoryview(self._data)[self.at : self.at + length]
        if len(part) < length:
            raise MessageError(f"it ends {length - len(part)} bytes early")
        self.at += length
        return part

    def block(self) -> memoryview:
        """Return a sequence of bytes, which its length precedes."""
        return self.take(self.number("I"))

    def text(self) -> str:
        """Return a string."""
        return bytes(self.block()).rstrip(b"\0").decode("utf-8", "replace")

    def header_stamp_ns(self) -> int:
        """Read a std_msgs/Header and return its time stamp [ns]."""
        if self.is_ros1:
            self.number("I")  # sequence number
        stamp_ns = self.number("I" if self.is_ros1 else "i") * 10**9 + self.number("I")
        self.text()  # frame of reference
        return int(stamp_ns)

    def column(self, code: str, count: int, *, offset: int, stride: int) -> Array:
        """Return one field of an array of records.

        Args:
            code: type of the field, as NumPy names it, without byte order.
            count: number of records.
            offset: position of the field in the first record, from `at` [bytes].
            stride: distance between records [bytes].
        """
        dtype = np.dtype(self.order + code)
        start = self.at + offset
        if not count:
            return np.empty(0, dtype)
        if start + stride * (count - 1) + dtype.itemsize > len(self._data):
            raise MessageError(f"it states {count} records, and is too short for them")
        return np.ndarray((count,), dtype, self._data, start, (stride,))
