"""Events, frames, IMU samples and triggers of a bag of ROS 1 or ROS 2."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from importlib import import_module
from os.path import commonpath
from pathlib import Path

from formats.columns import FileHeader, ParsedFile, ParsedItem, ReadOptions, Size
from formats.errors import FormatError, MissingLibraryError
from formats.readers.ros import messages
from formats.readers.ros.bags import SCAN_BYTES, Bag, Topic
from formats.readers.ros.fields import MessageError
from formats.readers.ros.packets import CLOCK_OF_SENSOR, PacketDecoder
from formats.samples import ParsedSamples

_EVENTS = messages.EVENT_ARRAYS + messages.EVENT_PACKETS
_DECODED = (*_EVENTS, messages.IMAGE, messages.IMU)


def read_rosbag1(path: Path, options: ReadOptions) -> ParsedFile:
    """Read a ROS 1 bag."""
    return _read(path, "rosbag1", "Rosbag1", options)


def read_rosbag2(path: Path, options: ReadOptions) -> ParsedFile:
    """Read a ROS 2 bag: a folder, or a SQLite file."""
    name = "Rosbag2Folder" if path.is_dir() else "SqliteBag"
    return _read(path, "rosbag2", name, options)


def read_mcap(path: Path, options: ReadOptions) -> ParsedFile:
    """Read an MCAP file."""
    return _read(path, "mcap_file", "McapFile", options)


def _read(path: Path, module: str, name: str, options: ReadOptions) -> ParsedFile:
    """Read one topic of events, and of images, IMU samples and triggers those that go with it.

    Raises:
        FormatError: there is no topic of events, or the bag is damaged.
        MissingLibraryError: rosbags or mcap is not installed.
    """
    try:
        bag: Bag = getattr(import_module(f"formats.readers.ros.{module}"), name)(path)
    except ImportError as error:
        raise MissingLibraryError(str(error.name).partition(".")[0], "a bag of ROS") from error
    content = _Content(path, bag, options.size)
    return content.header(), content.items()


class _Content:
    """The topics of a bag that are read."""

    def __init__(self, path: Path, bag: Bag, stated: Size | None) -> None:
        self._path, self._bag, self._decoder, self._shift = path, bag, PacketDecoder(), 0
        self._first, self._damage = _first_messages(bag)
        self._events = self._event_topic()
        self._size, self._encoding = self._facts_of(self._events)
        chosen = [
            self._events,
            self._nearest(t for t in bag.topics if self._is_image(t, stated)),
            self._nearest(t for t in bag.topics if t.kind == messages.IMU),
            self._trigger_topic(),
        ]
        self._topics = {topic.name: topic for topic in chosen if topic is not None}
        self._triggers = PacketDecoder()

    def header(self) -> FileHeader:
        """Return what the bag states, the topics that are read, and those that could be."""
        facts = {"topics": ", ".join(self._topics)}
        if self._encoding:
            facts["encoding"] = self._encoding
        if self._encoding in CLOCK_OF_SENSOR:
            facts["clock"] = "of the sensor, set to the time stamp of the first message"
        others = [t.name for t in self._bag.topics if t.name not in self._topics]
        if others:
            facts["not read"] = ", ".join(others)
        has_frames = any(topic.kind == messages.IMAGE for topic in self._topics.values())
        return FileHeader(self._size, facts, has_frames=has_frames)

    def items(self) -> Iterator[ParsedItem]:
        """Yield the content of the topics, in the order of the bag."""
        counts = dict.fromkeys(self._topics, 0)
        for name, data in self._bag.messages(self._topics.keys()):
            try:
                yield from self._decoded(self._topics[name], data)
            except (MessageError, OverflowError) as error:
                yield from self._decoder.flush()
                raise FormatError(
                    f"{self._path}: message {counts[name]} of {name} cannot be decoded: {error}. "
                    "The messages before it were read. Copy the file again."
                ) from error
            counts[name] += 1
        yield from self._decoder.flush()

    def _decoded(self, topic: Topic, data: bytes) -> Iterator[ParsedItem]:
        is_ros1 = topic.is_ros1
        if topic.kind in messages.EVENT_ARRAYS:
            yield messages.event_array(data, is_ros1=is_ros1)[1]
        elif topic.kind in messages.EVENT_PACKETS:
            decoder = self._decoder if topic == self._events else self._triggers
            yield from decoder.decode(messages.event_packet(data, is_ros1=is_ros1))
        elif topic.kind == messages.IMAGE:
            frame, self._shift = messages.image(data, self._shift, is_ros1=is_ros1)
            yield frame
        else:
            yield ParsedSamples(messages.imu(data, is_ros1=is_ros1))

    def _facts_of(self, topic: Topic) -> tuple[Size | None, str]:
        """Return the size of the sensor [px] and the encoding that a message of events states."""
        data = self._first[topic.name]
        try:
            if topic.kind in messages.EVENT_ARRAYS:
                size, encoding = messages.event_array(data, is_ros1=topic.is_ros1)[0], ""
            else:
                packet = messages.event_packet(data, is_ros1=topic.is_ros1)
                size, encoding = packet.size, packet.encoding
        except MessageError as error:
            raise FormatError(
                f"{self._path}: message 0 of {topic.name} cannot be decoded: {error}. Copy the "
                "file again."
            ) from error
        return (size if all(size) else None), encoding

    def _event_topic(self) -> Topic:
        """Return the topic of events that is read: that of a left camera, or else the first."""
        topics = [t for t in self._bag.topics if t.kind in _EVENTS and t.name in self._first]
        events = [topic for topic in topics if self._facts_of(topic)[1] != "trigger"]
        if not events and self._damage is not None:
            raise self._damage
        if not events:
            found = ", ".join(f"{t.name} ({t.kind})" for t in self._bag.topics) or "none"
            raise FormatError(
                f"{self._path} contains no message of events. Its topics are: {found}. Allowed is "
                f"a topic of the type {', '.join(_EVENTS)}. Record one, or give another bag."
            )
        return next((topic for topic in events if "left" in topic.name), events[0])

    def _trigger_topic(self) -> Topic | None:
        topics = [t for t in self._bag.topics if t.kind in messages.EVENT_PACKETS]
        topics = [t for t in topics if t.name in self._first and t != self._events]
        return next((t for t in topics if self._facts_of(t)[1] == "trigger"), None)

    def _nearest(self, topics: Iterable[Topic]) -> Topic | None:
        """Return the topic whose name has most in common with that of the events."""
        own = self._events.name.lstrip("/")
        known = (topic for topic in topics if topic.name in self._first)
        return max(known, key=lambda t: len(commonpath([t.name.lstrip("/"), own])), default=None)

    def _is_image(self, topic: Topic, stated: Size | None) -> bool:
        """Return True for images that can be decoded and have the size of the sensor."""
        if topic.kind != messages.IMAGE or topic.name not in self._first:
            return False
        try:
            frame, _ = messages.image(self._first[topic.name], 0, is_ros1=topic.is_ros1)
        except MessageError:
            return False
        size = stated or self._size
        return size is None or frame.image.shape == size[::-1]


def _first_messages(bag: Bag) -> tuple[dict[str, bytes], FormatError | None]:
    """Return the first message of each topic that can be decoded, and the error that ends it."""
    missing = {topic.name for topic in bag.topics if topic.kind in _DECODED}
    first: dict[str, bytes] = {}
    if bag.topics and not missing:
        return first, None
    searched = 0
    try:
        for name, data in bag.messages(frozenset(missing)):
            first.setdefault(name, data)
            missing.discard(name)
            searched += len(data)
            if not missing or searched > SCAN_BYTES:
                break
    except FormatError as error:
        return first, error
    return first, None
