"""ROS 2 bags and MCAP files, written by rosbags.

Events are messages of the type event_camera_msgs/EventPacket, because its drivers and tools are
maintained for ROS 2 (metavision_driver, libcaer_driver, event_camera_py), and it takes 8 bytes an
event where dvs_msgs takes 16. Its encoding is libcaer: the only one that is not deprecated, states
absolute times and is not compressed (see `formats.readers.ros.packets`). The container compresses.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np

from emulator import ApsFrame
from flybench.events import Events, empty_events
from formats.errors import FormatError, MissingLibraryError
from formats.writers.base import EventWriter

EVENTS_TOPIC = "/event_camera/events"
IMAGES_TOPIC = "/event_camera/image_raw"
PACKET_US = 10_000
"""Longest time that a packet spans (assumed): players deliver events in packets [µs]."""

_VERSION: Literal[8] = 8
"""Version of metadata.yaml; ROS 2 Humble and later read it."""

_LATEST_US = 2**31 * 10**6 - 1
"""Latest time in ROS, whose seconds have 32 bits and a sign [µs]."""

_PACKET = "event_camera_msgs/msg/EventPacket"
_IMAGE = "sensor_msgs/msg/Image"
_DEFINITION = """std_msgs/Header header
uint32 height
uint32 width
uint64 seq
uint64 time_base
string encoding
bool is_bigendian
uint8[] events
"""
"""Fields of the message (github.com/ros-event-camera/event_camera_msgs)."""

_LIBCAER = np.dtype([("data", "<u4"), ("t", "<i4")])
_LOW_BITS = 31


class Rosbag2Writer(EventWriter):
    """Writes a folder with metadata.yaml and one MCAP file, compressed by zstd.

    Frames are messages of the type sensor_msgs/Image, 10 bits in 16 (mono16); their time stamp is
    the end of the exposure.
    """

    takes_frames: ClassVar[bool] = True

    def __init__(self, path: Path, *, width: int, height: int, overwrite: bool = True) -> None:
        self._check_new(path)
        super().__init__(path, width=width, height=height, overwrite=overwrite)

    def _check_new(self, path: Path) -> None:
        if path.exists():
            raise FormatError(
                f"{path} exists already. A ROS 2 bag is a new folder. Remove it, or choose another "
                "name."
            )

    def _open(self, work: Path) -> None:
        try:
            from rosbags import rosbag2, typesys
        except ImportError as error:
            raise MissingLibraryError("rosbags", "writing a ROS 2 bag or MCAP") from error
        self._store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        self._store.register(typesys.get_types_from_msg(_DEFINITION, _PACKET))
        self._holder = work.with_name(f"{work.name}.parts")
        self._packets, self._images = 0, None
        self._holder.mkdir()
        plugin, modes = rosbag2.StoragePlugin.MCAP, rosbag2.CompressionMode
        self._bag: Any = rosbag2.Writer(
            self._holder / self.path.stem, version=_VERSION, storage_plugin=plugin
        )
        self._bag.set_compression(modes.STORAGE, rosbag2.CompressionFormat.ZSTD)
        self._bag.open()
        self._events = self._bag.add_connection(EVENTS_TOPIC, _PACKET, typestore=self._store)

    def _write(self, events: Events) -> None:
        last_us = int(events["t"][-1])
        if last_us > _LATEST_US:
            raise FormatError(
                f"{self.path}: an event has the time {last_us} µs. Allowed is up to {_LATEST_US}, "
                "because ROS counts seconds with 32 bits. Subtract the time of the first event."
            )
        cuts = np.flatnonzero(np.diff(events["t"] // PACKET_US)) + 1
        for packet in np.split(events, cuts):
            self._put_packet(packet, first_us=int(packet["t"][0]), last_us=int(packet["t"][-1]))

    def _put_packet(self, events: Events, *, first_us: int, last_us: int) -> None:
        fields = {"t_us": first_us, **self._packet_fields(events, first_us)}
        self._put(self._events, _PACKET, last_us, fields)
        self._packets += 1

    def _write_frame(self, frame: ApsFrame) -> None:
        if self._images is None:
            self._images = self._bag.add_connection(IMAGES_TOPIC, _IMAGE, typestore=self._store)
        pixels = np.ascontiguousarray(frame.image, "<u2").view(np.uint8).ravel()
        fields = {"encoding": "mono16", "is_bigendian": 0, "step": 2 * self.width, "data": pixels}
        self._put(self._images, _IMAGE, frame.end_us, {"t_us": frame.end_us, **fields})

    def _packet_fields(self, events: Events, first_us: int) -> dict[str, Any]:
        words = np.empty(events.size, _LIBCAER)
        x, y, on = (events[name].astype(np.uint32) for name in "xyp")
        words["data"] = x << 17 | y << 2 | on << 1 | 1  # the lowest bit marks a valid event
        words["t"] = events["t"] & (1 << _LOW_BITS) - 1
        time_base_ns = (first_us >> _LOW_BITS << _LOW_BITS) * 1000
        fields = {"seq": self._packets, "time_base": time_base_ns, "encoding": "libcaer"}
        data = words.view(np.uint8)
        return {**fields, "is_bigendian": False, "events": data}

    def _put(self, connection: Any, kind: str, logged_us: int, fields: dict[str, Any]) -> None:
        """Write a message; `fields` are those after its size, and t_us for its header."""
        types = self._store.types
        sec, us = divmod(fields.pop("t_us"), 1_000_000)
        stamp = types["builtin_interfaces/msg/Time"](sec=sec, nanosec=1000 * us)
        header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="event_camera")
        message = types[kind](header=header, height=self.height, width=self.width, **fields)
        self._bag.write(connection, logged_us * 1000, self._store.serialize_cdr(message, kind))

    def _finish(self) -> None:
        if not self._packets:  # an empty packet states the size of the sensor
            self._put_packet(empty_events(), first_us=0, last_us=0)
        self._bag.close()
        self._made().replace(self._work)

    def _made(self) -> Path:
        """Return the folder that rosbags has written."""
        return self._holder / self.path.stem

    def _abandon(self) -> None:
        with suppress(AttributeError):
            self._bag.abort()


class McapWriter(Rosbag2Writer):
    """Writes the MCAP file of a ROS 2 bag, without a folder around it."""

    def _check_new(self, path: Path) -> None:
        """Leave the check of a file to the base class."""

    def _made(self) -> Path:
        return super()._made() / f"{self.path.stem}.mcap"
