"""Encodings of event_camera_msgs/EventPacket.

Sources: the message's README (github.com/ros-event-camera/event_camera_msgs) and the decoders of
event_camera_codecs (github.com/ros-event-camera/event_camera_codecs).

| encoding | an event | time |
| --- | --- | --- |
| evt3 | Prophesee EVT 3.0 | clock of the sensor; `time_base` is not used |
| mono | 64 bits: ON (63), y (48 to 62), x (32 to 47), dt in ns (0 to 31) | `time_base` + dt |
| libcaer | 64 bits: t in µs (32 to 63), x (17 to 31), y (2 to 16), ON (1) | `time_base` + t |
| libcaer_cmp | 16-bit words as in EVT 3.0, rows and columns exchanged | `time_base` + t in µs |
| trigger | 64 bits: rising edge (63), dt in ns (0 to 31) | `time_base` + dt |

The clock of evt3, mono and trigger starts with the sensor. It is shifted so that the first event
has the time stamp of its message, which is the time of the other messages in the bag.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from formats.columns import Array, EventColumns
from formats.readers.ros.evt3 import Evt3Decoder
from formats.readers.ros.fields import MessageError
from formats.readers.ros.libcaer_compressed import decode_libcaer_compressed
from formats.readers.ros.messages import EventPacket
from formats.samples import TRIGGER_DTYPE, ParsedSamples, TriggerKind

ENCODINGS = ("evt3", "mono", "libcaer", "libcaer_cmp", "trigger")
CLOCK_OF_SENSOR = ("evt3", "mono", "trigger")
"""Encodings whose clock starts with the sensor."""

_COLLECT_BYTES = 1 << 17
"""Packets of EVT 3.0 are collected until there are this many bytes, then decoded at once."""

_LOW_BITS_LIBCAER = 31


class PacketDecoder:
    """Decodes the packets of one topic, in order."""

    def __init__(self) -> None:
        self._evt3 = Evt3Decoder()
        self._parts: list[bytes] = []
        self._size = 0
        self._stamp_ns = 0
        self._offset_us: int | None = None

    def decode(self, packet: EventPacket) -> Iterator[EventColumns | ParsedSamples]:
        """Yield the events and triggers of a packet, perhaps later than with the packet."""
        words = 2 if packet.encoding in ("evt3", "libcaer_cmp") else 8
        if len(packet.data) % words:
            raise MessageError(f"it has {len(packet.data)} bytes, which end within a word")
        if self._offset_us is None and not self._parts:
            self._stamp_ns = packet.stamp_ns
        if packet.encoding == "evt3":
            self._parts.append(packet.data)
            self._size += len(packet.data)
            if self._offset_us is None or self._size >= _COLLECT_BYTES:
                yield from self.flush()
        elif packet.encoding == "mono":
            yield self._shifted(_mono(packet))
        elif packet.encoding == "libcaer":
            yield _libcaer(packet)
        elif packet.encoding == "libcaer_cmp":
            yield decode_libcaer_compressed(packet)
        elif packet.encoding == "trigger":
            yield self._shifted_triggers(_triggers(packet))
        else:
            allowed = ", ".join(ENCODINGS)
            raise MessageError(f"its encoding is {packet.encoding!r}; allowed is one of {allowed}")

    def flush(self) -> Iterator[EventColumns | ParsedSamples]:
        """Yield what was collected."""
        data, self._parts, self._size = b"".join(self._parts), [], 0
        if not data:
            return
        events, triggers = self._evt3.decode(data)
        yield self._shifted(events)
        if triggers.size:
            yield self._shifted_triggers(ParsedSamples(triggers))

    def _shifted(self, events: EventColumns) -> EventColumns:
        return EventColumns(self._in_message_time(events.t), events.x, events.y, events.p)

    def _shifted_triggers(self, parsed: ParsedSamples) -> ParsedSamples:
        parsed.samples["t"] = self._in_message_time(parsed.samples["t"])
        return parsed

    def _in_message_time(self, t_us: Array) -> Array:
        if self._offset_us is None:
            if not t_us.size:
                return t_us
            self._offset_us = self._stamp_ns // 1000 - int(t_us[0]) if self._stamp_ns else 0
        return t_us + self._offset_us


def _mono(packet: EventPacket) -> EventColumns:
    words = np.frombuffer(packet.data, "<u8")
    t_ns = packet.time_base_ns + (words & 0xFFFFFFFF).astype(np.int64)
    x, y = (words >> 32) & 0xFFFF, (words >> 48) & 0x7FFF
    return EventColumns(t_ns // 1000, x.astype(np.int32), y.astype(np.int32), words >> 63 != 0)


def _triggers(packet: EventPacket) -> ParsedSamples:
    words = np.frombuffer(packet.data, "<u8")
    samples = np.zeros(words.size, TRIGGER_DTYPE)
    samples["t"] = (packet.time_base_ns + (words & 0xFFFFFFFF).astype(np.int64)) // 1000
    samples["kind"] = np.where(
        words >> 63 != 0, TriggerKind.EXTERNAL_RISING_EDGE, TriggerKind.EXTERNAL_FALLING_EDGE
    )
    samples["channel"] = (words >> 48) & 0xFF
    return ParsedSamples(samples)


def _libcaer(packet: EventPacket) -> EventColumns:
    """Decode events of libcaer; their clock of 31 bits may overflow within the packet."""
    words = np.frombuffer(packet.data, [("data", "<u4"), ("t", "<i4")])
    t_us = words["t"].astype(np.int64)
    t_us += np.cumsum(np.diff(t_us, prepend=t_us[:1]) < 0) << _LOW_BITS_LIBCAER
    data = words["data"]
    x, y = (data >> 17).astype(np.int32), ((data >> 2) & 0x7FFF).astype(np.int32)
    return EventColumns((packet.time_base_ns + 1000 * t_us) // 1000, x, y, (data >> 1) & 1 != 0)
