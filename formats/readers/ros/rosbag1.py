"""ROS 1 bags, version 2.0 (wiki.ros.org/Bags/Format/2.0).

The bag is read from its beginning to its end, and its index is used only to list the topics. So
a bag that was truncated, or that was never closed, gives the messages before the damage, and the
memory does not grow with the length of the bag. Records are decoded by functions of rosbags.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from io import BytesIO
from itertools import takewhile
from pathlib import Path
from typing import BinaryIO, NamedTuple

from rosbags.rosbag1.reader import (
    Header,
    RecordType,
    decompressors,
    normalize,
    read_bytes,
    read_uint32,
)

from formats.errors import FormatError
from formats.readers.ros.bags import SCAN_BYTES, RecordedMessage, Topic, damaged, ros2_kind

_MAGIC = b"#ROSBAG V2.0\n"
_SKIPPED = (RecordType.IDXDATA, RecordType.CHUNK_INFO)


class _Record(NamedTuple):
    """A record of a bag; `at` is its position, or that of its chunk, in the file [bytes]."""

    kind: int
    header: Header
    data: bytes
    at: int


class Rosbag1:
    """A ROS 1 bag."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._connections: dict[int, Topic] = {}
        with path.open("rb") as file:
            if file.read(len(_MAGIC)) != _MAGIC:
                raise FormatError(
                    f"{path} is a ROS bag of another version. Allowed is 2.0. Convert it with: "
                    "rosbag migrate"
                )
        for record in takewhile(lambda record: record.at < SCAN_BYTES, self._scanned()):
            self._add(record)

    @property
    def topics(self) -> tuple[Topic, ...]:
        """Topics, in the order of the file."""
        return tuple(dict.fromkeys(self._connections.values()))

    def messages(self, names: Set[str]) -> Iterator[RecordedMessage]:
        """Yield the messages of some topics, in the order of the file."""
        with self._path.open("rb") as file:
            for record in self._records(file, len(_MAGIC)):
                self._add(record)
                if record.kind == RecordType.MSGDATA:
                    topic = self._connections.get(record.header.get_uint32("conn"))
                    if topic is not None and topic.name in names:
                        yield topic.name, record.data

    def _scanned(self) -> Iterator[_Record]:
        """Yield the records of the index, or else all records; errors end it."""
        with self._path.open("rb") as file:
            try:
                file.seek(len(_MAGIC))
                index = Header.read(file, RecordType.BAGHEADER).get_uint64("index_pos")
                at = index if 0 < index < self._path.stat().st_size else len(_MAGIC)
                yield from self._records(file, at, position=0)
            except FormatError:  # `messages` raises it again
                return
            except Exception as error:
                raise damaged(self._path, "in its header", error) from error

    def _records(
        self, file: BinaryIO, at: int, *, position: int | None = None
    ) -> Iterator[_Record]:
        """Yield the records from `at` on, with those inside chunks instead of the chunks."""
        end = self._path.stat().st_size
        try:
            file.seek(at)
            while (at := file.tell()) < end:
                record = _read_record(file, at if position is None else position)
                if record.kind == RecordType.CHUNK:
                    yield from _records_in_chunk(record)
                else:
                    yield record
        except Exception as error:  # rosbags, bz2 and lz4 raise almost any type
            raise damaged(self._path, f"in the record at byte {at}", error) from error

    def _add(self, record: _Record) -> None:
        if record.kind == RecordType.CONNECTION:
            name = normalize(record.header.get_string("topic"))
            kind = _header_of(record.data).get_string("type")
            topic = Topic(name, ros2_kind(kind), is_ros1=True)
            self._connections[record.header.get_uint32("conn")] = topic


def _header_of(data: bytes) -> Header:
    return Header.read(BytesIO(len(data).to_bytes(4, "little") + data))


def _read_record(file: BinaryIO, at: int) -> _Record:
    header = Header.read(file)
    kind, length = header.get_uint8("op"), read_uint32(file)
    if kind in _SKIPPED:
        file.seek(length, 1)
        return _Record(kind, header, b"", at)
    return _Record(kind, header, read_bytes(file, length), at)


def _records_in_chunk(chunk: _Record) -> Iterator[_Record]:
    data = decompressors[chunk.header.get_string("compression")](chunk.data)
    if len(data) != chunk.header.get_uint32("size"):
        raise ValueError(f"a chunk has {len(data)} bytes, not those that it states")
    stream = BytesIO(data)
    while stream.tell() < len(data):
        yield _read_record(stream, chunk.at)
