"""EVT 3.0 as it arrives in pieces: 16-bit words, whose upper 4 bits are the type of the word.

Source: Prophesee, "EVT 3.0 Format" (docs.prophesee.ai, data encoding formats); the rule that the
clock overflows only when it falls by more than `BACK_MAX`: event_camera_codecs
(github.com/ros-event-camera/event_camera_codecs), which allows for bit errors of the sensor.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from formats.columns import Array, EventColumns
from formats.samples import TRIGGER_DTYPE, TriggerKind, empty_triggers

_ROW, _PIXEL, _BASE, _VECTOR_12, _VECTOR_8 = 0x0, 0x2, 0x3, 0x4, 0x5
_TIME_LOW, _TIME_HIGH, _TRIGGER = 0x6, 0x8, 0xA
_STATE = (_TIME_HIGH, _TIME_LOW, _ROW, _BASE)
BACK_MAX = 10
"""Largest step back of the high part of the time that is no overflow, in packets of a bag."""

_VALUE_BITS = 12
_MASK = (1 << _VALUE_BITS) - 1
_X_MASK = 0x7FF
_ON = 0x800

_Pixels: TypeAlias = tuple[Array, Array, Array]
"""Index of the word, column [px] and polarity of each event."""


class Evt3Decoder:
    """Decodes a stream of words, in pieces of any length.

    Words of the state (time, row, base of a vector) are repeated in front of the next piece, so
    that each piece is decoded as if it were the first.
    """

    def __init__(self, *, back_max: int = BACK_MAX) -> None:
        """Start a stream.

        Args:
            back_max: largest step back of the high part of the time that is no overflow, in its
                units of 4096 µs.
        """
        self._back_max = back_max
        self._state: dict[int, int] = {}
        self._loops = 0

    def decode(self, data: bytes) -> tuple[EventColumns, npt.NDArray[Any]]:
        """Return events and triggers, with t in µs of the sensor's clock; it starts below 17 s.

        Args:
            data: an even number of bytes.
        """
        before = [kind << _VALUE_BITS | self._state[kind] for kind in _STATE if kind in self._state]
        words = np.concatenate([np.array(before, "<u2"), np.frombuffer(data, "<u2")])
        kinds, values = (words >> _VALUE_BITS).astype(np.uint8), (words & _MASK).astype(np.int32)
        is_time = (kinds == _TIME_HIGH) | (kinds == _TIME_LOW)
        times_us = self._times(kinds[is_time], values[is_time])
        single = np.flatnonzero(kinds == _PIXEL)
        at, x, on = single, values[single] & _X_MASK, values[single] >= _ON
        vectors = np.flatnonzero((kinds == _VECTOR_12) | (kinds == _VECTOR_8))
        if vectors.size:
            at, x, on = _merged((at, x, on), self._vector_pixels(kinds, values, vectors))
        for kind in (_TIME_HIGH, _TIME_LOW, _ROW):
            self._keep(kind, values[kinds == kind])
        if not vectors.size:
            self._keep(_BASE, values[kinds == _BASE])
        t_us = latest(is_time, times_us, at, before=-1)
        row = latest(kinds == _ROW, values[kinds == _ROW] & _X_MASK, at)
        known = t_us >= 0
        events = EventColumns(t_us[known], x[known], row[known], on[known])
        return events, _triggers(kinds, values, is_time, times_us)

    def _times(self, kinds: Array, values: Array) -> Array:
        """Return the time after each word of time [µs]; -1 before the first complete time.

        The low part counts from 0 after a change of the high part until it is sent anew.
        """
        is_high = kinds == _TIME_HIGH
        highs = values[is_high]
        steps = np.diff(highs, prepend=highs[:1])
        loops = self._loops + np.cumsum(steps < -self._back_max)
        if highs.size:
            self._loops = int(loops[-1])
        high = latest(is_high, loops << _VALUE_BITS | highs)
        changes = latest(is_high, np.cumsum(steps != 0))
        is_low = ~is_high
        low = latest(is_low, values[is_low])
        is_new = latest(is_low, changes[is_low]) == changes
        known = latest(is_low, np.cumsum(is_high)[is_low]) > 0  # the low part came after a high one
        return np.where(known, high << _VALUE_BITS | np.where(is_new, low, 0), -1)

    def _vector_pixels(self, kinds: Array, values: Array, vectors: Array) -> _Pixels:
        """Return the events of vectors of 12 or 8 pixels, which start at a base and follow it."""
        lengths = np.where(kinds[vectors] == _VECTOR_12, 12, 8)
        ends = np.cumsum(lengths)
        bases = np.flatnonzero(kinds == _BASE)
        moved_before = np.append(0, ends)[np.searchsorted(vectors, bases)]
        base = latest(kinds == _BASE, values[bases], vectors)
        start = (base & _X_MASK) + ends - lengths
        start -= latest(kinds == _BASE, moved_before, vectors)
        bits = (values[vectors, None] >> np.arange(12)) & (np.arange(12) < lengths[:, None])
        which, bit = np.nonzero(bits & 1)
        self._keep(_BASE, values[bases[-1:]])
        if bases.size and vectors[-1] > bases[-1]:
            x = min(int(start[-1] + lengths[-1]), _X_MASK)
            self._keep(_BASE, base[-1:] & _ON | x)
        return vectors[which], start[which] + bit, base[which] >= _ON

    def _keep(self, kind: int, values: Array) -> None:
        if values.size:
            self._state[kind] = int(values[-1])


def latest(mask: Array, found: Array, at: Any = slice(None), *, before: int = 0) -> Array:
    """Return the latest masked value at each element.

    Args:
        mask: which elements have a value.
        found: the values, one for each masked element.
        at: elements at which it is wanted; default: all.
        before: value before the first masked element.
    """
    values = np.append(found.dtype.type(before), found)
    chosen: Array = values[np.cumsum(mask, dtype=np.int32)[at]]
    return chosen


def _merged(one: _Pixels, other: _Pixels) -> _Pixels:
    """Return the pixels of both in the order of their words."""
    at, x, on = (np.concatenate(both) for both in zip(one, other, strict=True))
    order = np.argsort(at, kind="stable")
    return at[order], x[order], on[order]


def _triggers(kinds: Array, values: Array, is_time: Array, times_us: Array) -> npt.NDArray[Any]:
    at = np.flatnonzero(kinds == _TRIGGER)
    if not at.size:
        return empty_triggers()
    samples = np.zeros(at.size, TRIGGER_DTYPE)
    samples["t"], samples["channel"] = (
        latest(is_time, times_us, at, before=-1),
        values[at] >> 8 & 0xF,
    )
    samples["kind"] = np.where(
        values[at] & 1 != 0, TriggerKind.EXTERNAL_RISING_EDGE, TriggerKind.EXTERNAL_FALLING_EDGE
    )
    return samples[samples["t"] >= 0]
