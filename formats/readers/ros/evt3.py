"""EVT 3.0 as it arrives in pieces: 16-bit words, whose upper 4 bits are the type of the word.

Source: Prophesee, "EVT 3.0 Format" (docs.prophesee.ai, data encoding formats); the rule that the
clock overflows only when it falls by more than `_BACK_MAX`: event_camera_codecs
(github.com/ros-event-camera/event_camera_codecs), which allows for bit errors of the sensor.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from formats.columns import Array, EventColumns
from formats.samples import TRIGGER_DTYPE, TriggerKind

_ROW, _PIXEL, _BASE, _VECTOR_12, _VECTOR_8 = 0x0, 0x2, 0x3, 0x4, 0x5
_TIME_LOW, _TIME_HIGH, _TRIGGER = 0x6, 0x8, 0xA
_STATE = (_TIME_HIGH, _TIME_LOW, _ROW, _BASE)
_BACK_MAX = 10
_LOW_BITS = 12
_MASK = (1 << _LOW_BITS) - 1
_X_MASK = 0x7FF


class Evt3Decoder:
    """Decodes a stream of words, in pieces of any length.

    Words of the state (time, row, base of a vector) are repeated in front of the next piece, so
    that each piece is decoded as if it were the first.
    """

    def __init__(self) -> None:
        self._state: dict[int, int] = {}
        self._loops = 0

    def decode(self, data: bytes) -> tuple[EventColumns, npt.NDArray[Any]]:
        """Return events and triggers, with t in µs of the sensor's clock; it starts below 17 s.

        Args:
            data: an even number of bytes.
        """
        before = [kind << 12 | self._state[kind] for kind in _STATE if kind in self._state]
        words = np.concatenate([np.array(before, "<u2"), np.frombuffer(data, "<u2")])
        kinds, values = words >> 12, (words & _MASK).astype(np.int64)
        t_us = self._times(kinds, values)
        row = latest(kinds == _ROW, values) & _X_MASK
        base = latest(kinds == _BASE, values)
        vector_x = (base & _X_MASK) + self._vector_offset(kinds)
        at, x, on = _pixels(kinds, values, vector_x, base >> 11)
        at_time = t_us[at] >= 0
        at, x, on = at[at_time], x[at_time], on[at_time]
        self._keep(kinds, values, vector_x, base)
        return EventColumns(t_us[at], x, row[at], on), _triggers(kinds, values, t_us)

    def _times(self, kinds: Array, values: Array) -> Array:
        """Return the time at each word [µs]; -1 before the first complete time.

        The low part counts from 0 after a change of the high part until it is sent anew.
        """
        is_high, is_low = kinds == _TIME_HIGH, kinds == _TIME_LOW
        highs = values[is_high]
        falls = np.diff(highs, prepend=highs[:1])
        loops = self._loops + np.cumsum(falls < -_BACK_MAX)
        if highs.size:
            self._loops = int(loops[-1])
        unwrapped = np.zeros_like(values)
        unwrapped[is_high] = (loops << _LOW_BITS) | highs
        changed = np.zeros_like(is_high)
        changed[is_high] = falls != 0
        high, low = latest(is_high, unwrapped), latest(is_low, values)
        last_low = _last_index(is_low)
        is_new = last_low > _last_index(changed)
        first_high = int(np.argmax(is_high)) if highs.size else is_high.size
        t_us = (high << _LOW_BITS) | np.where(is_new, low, 0)
        return np.where(last_low > first_high, t_us, -1)

    @staticmethod
    def _vector_offset(kinds: Array) -> Array:
        """Return how far the vectors since the last base have moved x, before each word [px]."""
        lengths = np.where(kinds == _VECTOR_12, 12, np.where(kinds == _VECTOR_8, 8, 0))
        moved = np.cumsum(lengths) - lengths
        return moved - latest(kinds == _BASE, moved)

    def _keep(self, kinds: Array, values: Array, vector_x: Array, base: Array) -> None:
        for kind in (_TIME_HIGH, _TIME_LOW, _ROW):
            found = np.flatnonzero(kinds == kind)
            if found.size:
                self._state[kind] = int(values[found[-1]])
        if (kinds == _BASE).any():
            last = int(kinds[-1])
            length = 12 if last == _VECTOR_12 else 8 if last == _VECTOR_8 else 0
            x = min(int(vector_x[-1]) + length, _X_MASK)
            self._state[_BASE] = int(base[-1]) & 0x800 | x


def _last_index(mask: Array) -> Array:
    """Return the index of the last True up to each element; -1: none."""
    indices = np.where(mask, np.arange(mask.size), -1)
    return np.maximum.accumulate(indices)


def latest(mask: Array, values: Array) -> Array:
    """Return the latest of the masked values at each element; 0 before the first."""
    index = _last_index(mask)
    return np.where(index >= 0, values[index], 0)


def _pixels(
    kinds: Array, values: Array, vector_x: Array, vector_on: Array
) -> tuple[Array, Array, Array]:
    """Return the word, column [px] and polarity of each event, in order."""
    single = np.flatnonzero(kinds == _PIXEL)
    parts = [(single, values[single] & _X_MASK, values[single] >> 11 != 0)]
    for kind, length in ((_VECTOR_12, 12), (_VECTOR_8, 8)):
        words = np.flatnonzero(kinds == kind)
        which, bit = np.nonzero((values[words, None] >> np.arange(length)) & 1)
        word = words[which]
        parts.append((word, vector_x[word] + bit, vector_on[word] != 0))
    at, x, on = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(at, kind="stable")
    return at[order], x[order], on[order]


def _triggers(kinds: Array, values: Array, t_us: Array) -> npt.NDArray[Any]:
    at = np.flatnonzero((kinds == _TRIGGER) & (t_us >= 0))
    samples = np.zeros(at.size, TRIGGER_DTYPE)
    rises = values[at] & 1 != 0
    samples["t"], samples["channel"] = t_us[at], (values[at] >> 8) & 0xF
    samples["kind"] = np.where(
        rises, TriggerKind.EXTERNAL_RISING_EDGE, TriggerKind.EXTERNAL_FALLING_EDGE
    )
    return samples
