"""Bags of ROS 1 and ROS 2, and MCAP files, made by rosbags and mcap."""

import shutil
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.writer import Writer as McapWriter
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from flybench.events import Events

SIZE = (346, 260)
EVENT = "uint16 x\nuint16 y\ntime ts\nbool polarity\n"
EVENT_ARRAY = "std_msgs/Header header\nuint32 height\nuint32 width\n{package}/Event[] events\n"
PACKET = (
    "std_msgs/Header header\nuint32 height\nuint32 width\nuint64 seq\nuint64 time_base\n"
    "string encoding\nbool is_bigendian\nuint8[] events\n"
)
PACKET_KIND = "event_camera_msgs/msg/EventPacket"


class Recorded(NamedTuple):
    """A message: topic, type and time at which it was recorded [ns]."""

    topic: str
    kind: str
    t_ns: int
    message: Any


@cache
def store(ros: int) -> Any:
    """Return the types of ROS 1 or 2 with those of event cameras."""
    made = get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_HUMBLE)
    types = get_types_from_msg(PACKET, PACKET_KIND)
    for package in ("dvs_msgs", "prophesee_event_msgs"):
        event = EVENT if ros == 1 else EVENT.replace("time", "builtin_interfaces/Time")
        types |= get_types_from_msg(event, f"{package}/msg/Event")
        array = EVENT_ARRAY.format(package=package)
        types |= get_types_from_msg(array, f"{package}/msg/EventArray")
    made.register(types)
    return made


def _time(ros: int, t_ns: int) -> Any:
    return store(ros).types["builtin_interfaces/msg/Time"](sec=t_ns // 10**9, nanosec=t_ns % 10**9)


def header(ros: int, t_ns: int) -> Any:
    more = {"seq": 7} if ros == 1 else {}
    kind = store(ros).types["std_msgs/msg/Header"]
    return kind(stamp=_time(ros, t_ns), frame_id="cam", **more)


def array_message(ros: int, events: Events, package: str = "dvs_msgs") -> Any:
    types = store(ros).types
    made = [
        types[f"{package}/msg/Event"](x=x, y=y, ts=_time(ros, t * 1000), polarity=p)
        for t, x, y, p in events.tolist()
    ]
    return types[f"{package}/msg/EventArray"](
        header=header(ros, 0), height=SIZE[1], width=SIZE[0], events=made
    )


def packet_message(
    ros: int, encoding: str, data: np.ndarray, *, stamp_ns: int = 0, time_base: int = 0
) -> Any:
    return store(ros).types[PACKET_KIND](
        header=header(ros, stamp_ns),
        height=SIZE[1],
        width=SIZE[0],
        seq=0,
        time_base=time_base,
        encoding=encoding,
        is_bigendian=False,
        events=np.ascontiguousarray(data).view(np.uint8).ravel(),
    )


def image_message(ros: int, pixels: np.ndarray, encoding: str, t_ns: int) -> Any:
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(pixels.shape[0], -1)
    rows = np.pad(rows, ((0, 0), (0, 3)))  # rows may be longer than their pixels
    return store(ros).types["sensor_msgs/msg/Image"](
        header=header(ros, t_ns),
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding=encoding,
        is_bigendian=0,
        step=rows.shape[1],
        data=rows.ravel(),
    )


def imu_message(ros: int, t_ns: int) -> Any:
    types = store(ros).types
    vector, turn = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    return types["sensor_msgs/msg/Imu"](
        header=header(ros, t_ns),
        orientation=turn(x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=np.zeros(9),
        angular_velocity=vector(x=np.pi, y=0.0, z=-np.pi / 2),
        angular_velocity_covariance=np.ones(9),
        linear_acceleration=vector(x=0.0, y=9.80665, z=-19.6133),
        linear_acceleration_covariance=np.ones(9),
    )


def write_bag(path: Path, recorded: Iterable[Recorded]) -> Path:
    """Write a bag; the ending of its name states which kind."""
    writers = {".bag": _write_bag1, ".db3": _write_sqlite, ".mcap": _write_mcap, "": _write_folder}
    writers[path.suffix](path, list(recorded))
    return path


def ros_of(path: Path) -> int:
    return 1 if path.suffix == ".bag" else 2


def _write_bag1(path: Path, recorded: list[Recorded]) -> None:
    path.unlink(missing_ok=True)
    writer = rosbag1.Writer(path)
    writer.set_compression(writer.CompressionFormat.LZ4)
    writer.chunk_threshold = 4096
    connections: dict[str, Any] = {}
    with writer:
        for topic, kind, t_ns, message in recorded:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store(1))
            writer.write(connections[topic], t_ns, store(1).serialize_ros1(message, kind))


def _write_bag2(path: Path, recorded: list[Recorded], plugin: Any) -> None:
    shutil.rmtree(path, ignore_errors=True)
    connections: dict[str, Any] = {}
    with rosbag2.Writer(path, version=8, storage_plugin=plugin) as writer:
        for topic, kind, t_ns, message in recorded:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store(2))
            writer.write(connections[topic], t_ns, store(2).serialize_cdr(message, kind))


def _write_folder(path: Path, recorded: list[Recorded]) -> None:
    _write_bag2(path, recorded, rosbag2.StoragePlugin.MCAP)


def _write_sqlite(path: Path, recorded: list[Recorded]) -> None:
    folder = path.with_suffix(".folder")
    _write_bag2(folder, recorded, rosbag2.StoragePlugin.SQLITE3)
    next(folder.glob("*.db3")).replace(path)
    shutil.rmtree(folder)


def _write_mcap(path: Path, recorded: list[Recorded]) -> None:
    with path.open("wb") as file:
        writer = McapWriter(file, chunk_size=4096)
        writer.start(profile="ros2")
        channels: dict[str, int] = {}
        for topic, kind, t_ns, message in recorded:
            if topic not in channels:
                schema = writer.register_schema(kind, "ros2msg", b"")
                channels[topic] = writer.register_channel(topic, "cdr", schema)
            data = bytes(store(2).serialize_cdr(message, kind))
            writer.add_message(channels[topic], t_ns, data, t_ns)
        writer.finish()  # type: ignore[no-untyped-call]


def events_recorded(path: Path, events: Events, parts: int = 5) -> list[Recorded]:
    """Return messages of the type dvs_msgs/EventArray, one for each part of the events."""
    ros = ros_of(path)
    return [
        Recorded(
            "/dvs/events",
            "dvs_msgs/msg/EventArray",
            int(part["t"][-1]) * 1000,
            array_message(ros, part),
        )
        for part in np.array_split(events, parts)
    ]
