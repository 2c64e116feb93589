"""Messages of event cameras and image sensors, decoded.

Definitions: dvs_msgs (github.com/uzh-rpg/rpg_dvs_ros), prophesee_event_msgs
(github.com/prophesee-ai/prophesee_ros_wrapper; same fields), event_camera_msgs
(github.com/ros-event-camera/event_camera_msgs; event_array_msgs is its former name), sensor_msgs
(github.com/ros2/common_interfaces).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from formats.columns import Array, EventColumns, ParsedFrame, Size
from formats.readers.ros.fields import MessageError, MessageFields
from formats.samples import IMU_DTYPE

EVENT_ARRAYS = ("dvs_msgs/msg/EventArray", "prophesee_event_msgs/msg/EventArray")
EVENT_PACKETS = ("event_camera_msgs/msg/EventPacket", "event_array_msgs/msg/EventArray")
IMAGE = "sensor_msgs/msg/Image"
IMU = "sensor_msgs/msg/Imu"

_G_M_S2 = 9.80665
_LUMA = {"rgb": (0.299, 0.587, 0.114), "bgr": (0.114, 0.587, 0.299)}
"""Weights of the channels in luma (ITU-R BT.601), by the beginning of the encoding."""

_GREY = {"mono8": 8, "8UC1": 8, "mono16": 16, "16UC1": 16}
"""Bits per pixel of grey encodings (sensor_msgs/image_encodings)."""

_COLOUR = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4}
"""Channels of colour encodings."""


@dataclass(frozen=True, eq=False)
class EventPacket:
    """An event_camera_msgs/EventPacket.

    Attributes:
        stamp_ns: time stamp of the header [ns].
        size: width and height of the sensor [px].
        time_base_ns: time that some encodings count from [ns].
        encoding: name of the encoding of `data`.
        data: encoded events.
    """

    stamp_ns: int
    size: Size
    time_base_ns: int
    encoding: str
    data: bytes


def event_array(data: bytes, *, is_ros1: bool) -> tuple[Size, EventColumns]:
    """Decode a dvs_msgs/EventArray: size of the sensor [px], and events with t in µs.

    An event is x, y (uint16), seconds, nanoseconds (32 bits each) and polarity (bool). ROS 1 packs
    it into 13 bytes. In CDR the first event has 14 bytes, and the others 16, because their
    seconds are aligned to 4 bytes.
    """
    fields = MessageFields(data, is_ros1=is_ros1)
    fields.header_stamp_ns()
    height, width, count = (fields.number("I") for _ in range(3))
    if is_ros1:
        return (width, height), _records(fields, count, gap=0, stride=13)
    first = _records(fields, min(count, 1), gap=0, stride=14)
    fields.at += 14
    rest = _records(fields, max(count - 1, 0), gap=2, stride=16)
    both = (np.concatenate([getattr(first, name), getattr(rest, name)]) for name in "txyp")
    return (width, height), EventColumns(*both)


def _records(fields: MessageFields, count: int, *, gap: int, stride: int) -> EventColumns:
    def column(code: str, offset: int) -> Array:
        return fields.column(code, count, offset=offset, stride=stride)

    x, y = column("u2", 0), column("u2", 2)
    seconds = column("u4" if fields.is_ros1 else "i4", 4 + gap)
    t_us = seconds.astype(np.int64) * 1_000_000 + column("u4", 8 + gap) // 1000
    return EventColumns(t_us, x, y, column("u1", 12 + gap) != 0)


def event_packet(data: bytes, *, is_ros1: bool) -> EventPacket:
    """Decode the fields of an event_camera_msgs/EventPacket, but not its events."""
    fields = MessageFields(data, is_ros1=is_ros1)
    stamp_ns = fields.header_stamp_ns()
    height, width = fields.number("I"), fields.number("I")
    fields.number("Q")  # sequence number
    time_base_ns = fields.number("Q")
    encoding, is_bigendian = fields.text(), fields.number("?")
    if is_bigendian:
        raise MessageError("its events are big-endian; little-endian events can be read")
    return EventPacket(stamp_ns, (width, height), time_base_ns, encoding, bytes(fields.block()))


def image(data: bytes, shift: int, *, is_ros1: bool) -> tuple[ParsedFrame, int]:
    """Decode a sensor_msgs/Image to 10-bit grey levels.

    Args:
        data: the message.
        shift: right shift of earlier 16-bit images.
        is_ros1: True if it is serialised as in ROS 1.

    Returns:
        The frame, which begins and ends at its time stamp, because the message does not state the
        exposure; and the right shift for 16-bit images from now on: 6 once one exceeds 10 bits.
    """
    fields = MessageFields(data, is_ros1=is_ros1)
    t_us = fields.header_stamp_ns() // 1000
    height, width, encoding = fields.number("I"), fields.number("I"), fields.text()
    is_bigendian, step = fields.number("B"), fields.number("I")
    rows = np.frombuffer(fields.block(), np.uint8)
    if not height or not width or rows.size != height * step:
        raise MessageError(f"it states {width}x{height} px and has {rows.size} bytes")
    pixels = rows.reshape(height, step)
    if encoding in _GREY:
        code = "u1" if _GREY[encoding] == 8 else (">u2" if is_bigendian else "<u2")
        grey = _whole_rows(pixels, width * np.dtype(code).itemsize).view(code)
    elif encoding in _COLOUR:
        channels = _COLOUR[encoding]
        colour = _whole_rows(pixels, width * channels).reshape(height, width, channels)
        weights = np.array(_LUMA[encoding[:3]], np.float32)
        grey = np.rint(colour[..., :3].astype(np.float32) @ weights).astype(np.uint8)
    else:
        allowed = ", ".join((*_GREY, *_COLOUR))
        raise MessageError(f"its encoding is {encoding}; allowed is one of {allowed}")
    levels = grey.astype(np.uint16)
    if grey.dtype == np.uint8:
        return ParsedFrame(t_us, t_us, np.left_shift(levels, 2, dtype=np.uint16)), shift
    shift = 6 if shift or (levels > 1023).any() else 0
    return ParsedFrame(t_us, t_us, np.right_shift(levels, shift, dtype=np.uint16)), shift


def _whole_rows(pixels: npt.NDArray[np.uint8], length: int) -> npt.NDArray[np.uint8]:
    """Return rows without the bytes that pad them."""
    if pixels.shape[1] < length:
        raise MessageError(f"its rows have {pixels.shape[1]} bytes and need {length}")
    return np.ascontiguousarray(pixels[:, :length])


def imu(data: bytes, *, is_ros1: bool) -> npt.NDArray[Any]:
    """Decode a sensor_msgs/Imu, in rad/s and m/s², to one sample of `IMU_DTYPE`."""
    fields = MessageFields(data, is_ros1=is_ros1)
    sample = np.zeros(1, IMU_DTYPE)
    sample["magnetic_ut"] = sample["temperature_c"] = np.nan
    sample["t"] = fields.header_stamp_ns() // 1000
    numbers = [fields.number("d") for _ in range(4 + 9 + 3 + 9 + 3)]
    sample["rotation_deg_s"] = np.degrees(numbers[13:16])  # after orientation and its covariance
    sample["acceleration_g"] = np.divide(numbers[25:28], _G_M_S2)
    return sample
