"""The encoding libcaer_cmp of event_camera_msgs/EventPacket.

Source: event_camera_codecs (github.com/ros-event-camera/event_camera_codecs, libcaer_cmp_types.h
and libcaer_cmp_decoder.h). 16-bit words, whose upper 4 bits are the type; each packet is complete.
"""

from __future__ import annotations

import numpy as np

from formats.columns import Array, EventColumns
from formats.readers.ros.evt3 import latest
from formats.readers.ros.fields import MessageError
from formats.readers.ros.messages import EventPacket

_TIME_HIGH, _TIME_LOW, _COLUMN, _PIXEL, _BASE, _VECTOR_8 = range(6)
_MASK = 0xFFF
_Y_MASK = 0x7FF


def decode_libcaer_compressed(packet: EventPacket) -> EventColumns:
    """Decode a packet; times are `time_base` and up to 24 bits of µs."""
    words = np.frombuffer(packet.data, "<u2")
    kinds, values = words >> 12, (words & _MASK).astype(np.int64)
    if kinds.size and kinds.max() > _VECTOR_8:
        raise MessageError(f"it has a word of the type {kinds.max()}; allowed is 0 to {_VECTOR_8}")

    def last(kind: int, found: Array = values) -> Array:
        return latest(kinds == kind, found[kinds == kind])

    t_us = (last(_TIME_HIGH) << 12 | last(_TIME_LOW)) + packet.time_base_ns // 1000
    column, base = last(_COLUMN) & _Y_MASK, last(_BASE)
    lengths = np.where(kinds == _VECTOR_8, 8, 0)
    moved = np.cumsum(lengths) - lengths
    vector_y = (base & _Y_MASK) + moved - last(_BASE, moved)
    single, vectors = np.flatnonzero(kinds == _PIXEL), np.flatnonzero(kinds == _VECTOR_8)
    which, bit = np.nonzero((values[vectors, None] >> np.arange(8)) & 1)
    at = np.concatenate([single, vectors[which]])
    y = np.concatenate([values[single] & _Y_MASK, vector_y[vectors[which]] + bit])
    on = np.concatenate([values[single] >> 11, base[vectors[which]] >> 11]) != 0
    order = np.argsort(at, kind="stable")
    return EventColumns(t_us[at[order]], column[at[order]], y[order], on[order])
