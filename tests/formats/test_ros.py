"""Read and write bags of ROS 1 and ROS 2, and MCAP files."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags import rosbag1, rosbag2
from rosbags.highlevel import AnyReader

from flybench.events import EVENT_DTYPE, Events, concatenate_events
from formats import FormatError, TriggerKind, open_events, open_writer, read_events
from formats.readers.ros.evt3 import Evt3Decoder
from formats.writers import write_events
from tests.formats.evt3_words import evt3_words
from tests.formats.ros_files import (
    PACKET_KIND,
    Recorded,
    array_message,
    events_recorded,
    image_message,
    imu_message,
    packet_message,
    ros_of,
    store,
    write_bag,
)
from tests.formats.sample_files import SIZE, random_events, random_frames

E = random_events(2000)
BAGS = pytest.mark.parametrize("name", ["a.bag", "a.db3", "a.mcap", "bag"])
WALL_US = 1_700_000_000_000_000


@BAGS
@pytest.mark.parametrize(("package", "count"), [("dvs_msgs", 1), ("prophesee_event_msgs", 1999)])
def test_event_arrays(tmp_path: Path, name: str, package: str, count: int) -> None:
    path, kind = tmp_path / name, f"{package}/msg/EventArray"
    parts = np.split(E, [count])
    recorded = [
        Recorded("/cam/events", kind, k, array_message(ros_of(path), part, package))
        for k, part in enumerate((parts[0], E[:0], parts[1]))
    ]
    with open_events(write_bag(path, recorded)) as file:
        assert (file.width, file.height, file.size_source) == (*SIZE, "the file")
        assert file.header_fields["topics"] == "/cam/events"
        assert "not read" not in file.header_fields
        assert np.array_equal(concatenate_events([c.events for c in file]), E)


def mono(events: Events, base_us: int) -> np.ndarray:
    word = ((events["t"] - base_us) * 1000).astype(np.uint64)
    for name, shift in (("x", 32), ("y", 48), ("p", 63)):
        word |= events[name].astype(np.uint64) << np.uint64(shift)
    return word


def libcaer(events: Events) -> np.ndarray:
    data = np.zeros(events.size, [("data", "<u4"), ("t", "<u4")])
    x, y, p = (events[name].astype(np.uint32) for name in "xyp")
    data["data"], data["t"] = x << 17 | y << 2 | p << 1, events["t"] & 0x7FFFFFFF
    return data


def compressed(events: Events) -> np.ndarray:
    """Encode events in both ways: alone, and in vectors of 8 rows."""
    words: list[int] = []
    for k, (t, x, y, p) in enumerate(events.tolist()):
        words += [t >> 12, 1 << 12 | t & 0xFFF, 2 << 12 | x]
        if k % 2 or y < 8:
            words.append(3 << 12 | p << 11 | y)
        else:  # an empty vector moves y on by 8
            words += [4 << 12 | p << 11 | (y - 8), 5 << 12, 5 << 12 | 1]
    return np.array(words, "<u2")


@BAGS
def test_mono_packets_have_the_time_of_the_messages(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    ros, first_us = ros_of(path), int(E["t"][0])
    stamp_ns = (WALL_US + first_us) * 1000
    packets = [
        packet_message(ros, "mono", mono(part, base), stamp_ns=stamp_ns, time_base=base * 1000)
        for part in np.array_split(E, 3)
        for base in [int(part["t"][0]) - 1]
    ]
    recorded = [Recorded("/cam/events", PACKET_KIND, k, p) for k, p in enumerate(packets)]
    with open_events(write_bag(path, recorded)) as file:
        got = concatenate_events([c.events for c in file])
    assert file.header_fields["encoding"] == "mono"
    assert file.header_fields["clock"].startswith("of the sensor")
    assert file.origin_us == WALL_US + first_us
    got["t"] += first_us
    assert np.array_equal(got, E)


@pytest.mark.parametrize("encode", [libcaer, compressed])
def test_packets_with_absolute_times(tmp_path: Path, encode: Any) -> None:
    encoding = {libcaer: "libcaer", compressed: "libcaer_cmp"}[encode]
    packets = [
        packet_message(2, encoding, encode(part), time_base=5_000_000_000)
        for part in np.array_split(E, 3)
    ]
    recorded = [Recorded("/cam/events", PACKET_KIND, k, p) for k, p in enumerate(packets)]
    got = read_events(write_bag(tmp_path / "a.mcap", recorded))
    got["t"] -= 5_000_000
    assert np.array_equal(got, E)


def test_a_packet_of_libcaer_whose_clock_overflows(tmp_path: Path) -> None:
    events = E[:4].copy()
    events["t"] = [2**31 - 2, 2**31 - 1, 2**31, 2**31 + 7]
    packet = packet_message(2, "libcaer", libcaer(events))
    path = write_bag(tmp_path / "a.mcap", [Recorded("/e", PACKET_KIND, 0, packet)])
    assert np.array_equal(read_events(path), events)


@pytest.mark.parametrize("packet_bytes", [2, 14, 1000, 10**6])
def test_evt3_in_pieces_of_any_length(packet_bytes: int) -> None:
    events = random_events(1500, last_us=60_000_000)  # the clock of 24 bits overflows three times
    events["t"] += 3
    data, decoder = evt3_words(events).tobytes(), Evt3Decoder()
    parts = [
        decoder.decode(data[at : at + packet_bytes])[0] for at in range(0, len(data), packet_bytes)
    ]
    got = np.zeros(events.size, EVENT_DTYPE)
    for name in "txyp":
        got[name] = np.concatenate([getattr(part, name) for part in parts])
    assert np.array_equal(got, events)


def test_evt3_times() -> None:
    words = [
        0x2005,  # an event before the first time is not counted
        0x6001, 0x2005,  # nor one before the first high part
        0x8002, 0x2005,  # nor one before the low part that follows it
        0x6003, 0x2006,
        0x8002, 0x2007,  # the high part again: the low part stays
        0x8003, 0x2008,  # a new high part: the low part counts from 0
        0x6004, 0xA101, 0xA000,
        0x8000, 0x6004, 0x2009,  # a fall by 10 or less is no overflow
        0xE000, 0x7001, 0xF002,  # words of other types
    ]  # fmt: skip
    events, triggers = Evt3Decoder().decode(np.array(words, "<u2").tobytes())
    assert events.t.tolist() == [2 << 12 | 3, 2 << 12 | 3, 3 << 12, 4]
    assert events.x.tolist() == [6, 7, 8, 9]
    assert triggers["t"].tolist() == [3 << 12 | 4] * 2
    assert triggers["channel"].tolist() == [1, 0]
    rises, falls = TriggerKind.EXTERNAL_RISING_EDGE, TriggerKind.EXTERNAL_FALLING_EDGE
    assert triggers["kind"].tolist() == [rises, falls]


def test_evt3_packets_and_triggers_of_a_bag(tmp_path: Path) -> None:
    first_us, stamp_ns = int(E["t"][0]), WALL_US * 1000
    data = np.append(evt3_words(E), [0xA301]).astype("<u2")
    packets = [packet_message(2, "evt3", p, stamp_ns=stamp_ns) for p in np.array_split(data, 7)]
    recorded = [Recorded("/e", PACKET_KIND, k, p) for k, p in enumerate(packets)]
    trigger = np.array([1 << 63 | 2000], np.uint64)
    message = packet_message(2, "trigger", trigger, stamp_ns=stamp_ns + 5000, time_base=1000)
    recorded.append(Recorded("/t", PACKET_KIND, 9, message))
    with open_events(write_bag(tmp_path / "a.mcap", recorded)) as file:
        chunks = list(file)
    got = concatenate_events([c.events for c in chunks])
    got["t"] += first_us
    assert np.array_equal(got, E)
    triggers = np.concatenate([c.triggers for c in chunks])
    assert sorted(triggers["t"].tolist()) == [5, int(E["t"][-1]) - first_us]
    assert file.header_fields["topics"] == "/e, /t"


IMAGES: dict[str, Any] = {
    "mono8": lambda grey: (grey >> 2).astype(np.uint8),
    "mono16": lambda grey: (grey << 6).astype("<u2"),
    "bgr8": lambda grey: np.repeat((grey >> 2).astype(np.uint8)[..., None], 3, -1),
    "rgba8": lambda grey: np.repeat((grey >> 2).astype(np.uint8)[..., None], 4, -1),
}


@pytest.mark.parametrize(
    ("name", "encoding"), list(zip(("a.bag", "a.db3", "a.mcap", "bag"), IMAGES, strict=True))
)
def test_images_and_imu_that_go_with_the_events(tmp_path: Path, name: str, encoding: str) -> None:
    path, grey = tmp_path / name, random_frames(1)[0].image & 0x3FC
    ros = ros_of(path)
    small = image_message(ros, np.zeros((3, 4), np.uint8), "mono8", 0)
    pixels = IMAGES[encoding](grey)
    image = "sensor_msgs/msg/Image"
    other = image_message(ros, pixels, "bayer_rggb8" if encoding == "mono8" else encoding, 0)
    recorded = events_recorded(path, E)
    recorded[1:1] = [
        Recorded("/front/image", image, 0, small if encoding == "mono16" else other),
        Recorded("/dvs/image_raw", image, 1, image_message(ros, pixels, encoding, 30_000_500)),
        Recorded("/dvs/imu", "sensor_msgs/msg/Imu", 2, imu_message(ros, 20_000_000)),
    ]
    with open_events(write_bag(path, recorded)) as file:
        chunks = list(file)
    assert file.has_frames
    assert file.header_fields["topics"] == "/dvs/events, /dvs/image_raw, /dvs/imu"
    assert file.header_fields["not read"] == "/front/image"
    (frame,) = (frame for chunk in chunks for frame in chunk.frames)
    assert (frame.start_us, frame.end_us) == (30_000, 30_000)
    assert np.array_equal(frame.image, grey)
    (imu,) = np.concatenate([chunk.imu for chunk in chunks])
    assert imu["t"] == 20_000
    assert imu["rotation_deg_s"] == pytest.approx([180, 0, -90])
    assert imu["acceleration_g"] == pytest.approx([0, 1, -2])
    assert np.isnan(imu["temperature_c"])


def test_the_left_of_two_cameras_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    both = [
        Recorded(f"/{side}/events", "dvs_msgs/msg/EventArray", 0, array_message(2, events))
        for side, events in (("right", E[:3]), ("left", E))
    ]
    with open_events(write_bag(path, both)) as file:
        assert sum(chunk.events.size for chunk in file) == E.size
        assert file.header_fields["not read"] == "/right/events"


@pytest.mark.parametrize("name", ["a.bag", "a.mcap"])
def test_a_truncated_bag_gives_what_comes_before(tmp_path: Path, name: str) -> None:
    path = write_bag(tmp_path / name, events_recorded(tmp_path / name, E, parts=40))
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    got: list[Events] = []
    with (
        open_events(path) as file,
        pytest.raises(FormatError, match=r"truncated or damaged .* The messages before that were"),
    ):
        got.extend(chunk.events for chunk in file)
    whole = concatenate_events(got)
    assert 500 < whole.size < 1500
    assert np.array_equal(whole, E[: whole.size])


@pytest.mark.parametrize("name", ["a.bag", "a.mcap"])
def test_a_bag_truncated_before_its_first_message(tmp_path: Path, name: str) -> None:
    path = write_bag(tmp_path / name, events_recorded(tmp_path / name, E, parts=1))
    path.write_bytes(path.read_bytes()[: 4200 if name == "a.bag" else 100])
    with pytest.raises(FormatError, match=r"a\.\w+ is truncated or damaged"):
        open_events(path)


def test_an_image_that_waits_for_events_is_given_before_an_error(tmp_path: Path) -> None:
    after_ns = (int(E["t"][-1]) + 50) * 1000
    image = image_message(2, np.zeros(SIZE[::-1], np.uint8), "mono8", after_ns)
    recorded = [
        Recorded("/cam/events", PACKET_KIND, 0, packet_message(2, "libcaer", libcaer(E))),
        Recorded("/cam/image", "sensor_msgs/msg/Image", after_ns, image),
        Recorded("/cam/events", PACKET_KIND, after_ns, packet_message(2, "unknown", libcaer(E))),
    ]
    with open_events(write_bag(tmp_path / "a.mcap", recorded)) as file:
        with pytest.raises(FormatError, match="message 1 of /cam/events cannot be decoded"):
            list(file)
        assert (file.statistics.events, file.statistics.frames) == (E.size, 1)


def test_a_ros1_bag_that_was_never_closed(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "a.bag", events_recorded(tmp_path / "a.bag", E))
    data = path.read_bytes()
    end = rosbag1_index_position(path)
    path.write_bytes(data[:end].replace(end.to_bytes(8, "little"), bytes(8)))
    assert np.array_equal(read_events(path), E)


def rosbag1_index_position(path: Path) -> int:
    with path.open("rb") as file:
        file.readline()
        return rosbag1.reader.Header.read(file).get_uint64("index_pos")


def test_messages_compressed_one_by_one(tmp_path: Path) -> None:
    writer = rosbag2.Writer(tmp_path / "bag", version=8)
    writer.set_compression(rosbag2.CompressionMode.MESSAGE, rosbag2.CompressionFormat.ZSTD)
    with writer:
        kind = "dvs_msgs/msg/EventArray"
        topic = writer.add_connection("/dvs/events", kind, typestore=store(2))
        for item in events_recorded(tmp_path / "bag", E):
            writer.write(topic, item.t_ns, store(2).serialize_cdr(item.message, kind))
    assert np.array_equal(read_events(tmp_path / "bag"), E)


def test_refusals_of_bags(tmp_path: Path) -> None:
    image = image_message(2, np.zeros((3, 4), np.uint8), "mono8", 0)
    path = write_bag(tmp_path / "a.mcap", [Recorded("/i", "sensor_msgs/msg/Image", 0, image)])
    with pytest.raises(FormatError, match=r"no message of events\. Its topics are: /i \(sensor"):
        read_events(path)
    packet = packet_message(2, "huffman", np.zeros(8, np.uint8))
    path = write_bag(tmp_path / "b.mcap", [Recorded("/e", PACKET_KIND, 0, packet)])
    with pytest.raises(FormatError, match=r"message 0 of /e .*'huffman'; allowed is one of evt3"):
        read_events(path)
    (tmp_path / "bag").mkdir()
    with pytest.raises(FormatError, match="is a folder"):
        read_events(tmp_path / "bag")
    (tmp_path / "bag" / "metadata.yaml").write_text("a: [")
    with pytest.raises(FormatError, match="does not list the files"):
        read_events(tmp_path / "bag")
    listing = "rosbag2_bagfile_information: {relative_file_paths: [../b.db3.zstd]}"
    (tmp_path / "bag" / "metadata.yaml").write_text(listing)
    with pytest.raises(FormatError, match=r"bag/b.db3.zstd is missing or not a file"):
        read_events(tmp_path / "bag")
    (tmp_path / "bag" / "b.db3.zstd").write_bytes(b"\x28\xb5\x2f\xfd")
    with pytest.raises(FormatError, match=r"Unpack it with unzstd first"):
        read_events(tmp_path / "bag")


@pytest.mark.parametrize(("name", "format"), [("a.mcap", None), ("bag", "rosbag2")])
def test_written_bags_are_read_by_rosbags(tmp_path: Path, name: str, format: str | None) -> None:  # noqa: A002
    path, frames = tmp_path / name, random_frames()
    with open_writer(path, width=346, height=260, format=format) as writer:
        writer.write(E[:900])
        for frame in frames:
            writer.write_frame(frame)
        writer.write(E[900:])
    images: list[Any] = []
    packets: list[Any] = []
    with AnyReader([path], default_typestore=store(2)) as reader:
        for connection, logged_ns, data in reader.messages():
            message: Any = reader.deserialize(data, connection.msgtype)
            (packets if "Packet" in connection.msgtype else images).append((logged_ns, message))
    for _, packet in packets:
        assert (packet.encoding, packet.width, packet.height) == ("libcaer", 346, 260)
    assert packets[0][1].header.stamp.nanosec == int(E["t"][0]) * 1000
    words = np.concatenate([p.events for _, p in packets]).view("<u4").reshape(-1, 2)
    assert np.array_equal(words[:, 1], E["t"])
    assert np.array_equal(words[:, 0] >> 17, E["x"])
    assert np.array_equal(words[:, 0] >> 2 & 0x7FFF, E["y"])
    assert np.array_equal(words[:, 0] >> 1 & 1, E["p"])
    assert [logged_ns for logged_ns, _ in images] == [frame.end_us * 1000 for frame in frames]
    assert np.array_equal(images[1][1].data.view("<u2").reshape(260, 346), frames[1].image)
    with open_events(path) as file:
        chunks = list(file)
    assert np.array_equal(concatenate_events([c.events for c in chunks]), E)
    read = [frame for chunk in chunks for frame in chunk.frames]
    assert all(np.array_equal(a.image, b.image) for a, b in zip(read, frames, strict=True))
    assert [f.end_us for f in read] == [f.end_us for f in frames]


def test_times_beyond_31_bits_are_written(tmp_path: Path) -> None:
    events = E[:3].copy()
    events["t"] = [5, 2**31 - 1, 2**33 + 1]
    write_events(tmp_path / "a.mcap", [events], width=346, height=260)
    assert np.array_equal(read_events(tmp_path / "a.mcap"), events)
    events["t"][2] = 2**31 * 10**6
    with pytest.raises(FormatError, match="counts seconds with 32 bits"):
        write_events(tmp_path / "a.mcap", [events], width=346, height=260)
    assert np.array_equal(read_events(tmp_path / "a.mcap")["t"][:2], events["t"][:2])


def test_a_folder_is_whole_or_absent_and_never_replaced(tmp_path: Path) -> None:
    def write() -> None:
        with open_writer(tmp_path / "bag", width=346, height=260, format="rosbag2") as writer:
            writer.write(E)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write()
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "bag").mkdir()
    with pytest.raises(FormatError, match="exists already"):
        write()
