"""MCAP files (mcap.dev/spec) of ROS 1 or ROS 2 messages, read from beginning to end.

So a file that was truncated gives the messages before the damage. The summary at the end of the
file is used only to list the topics.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from pathlib import Path
from typing import BinaryIO

from mcap.reader import SeekingReader
from mcap.records import Channel, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader

from formats.readers.ros.bags import SCAN_BYTES, RecordedMessage, Topic, damaged, ros2_kind

_RECORD_MAX = 1 << 29
"""Longest record [bytes]; more does not fit into the memory of the parser."""

_SERIALISED_AS_ROS1 = {"ros1": True, "cdr": False}
"""Whether messages are serialised as in ROS 1, by the encoding that a channel states."""


class McapFile:
    """A file of messages of ROS 1 or ROS 2; other messages are left out."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._kinds: dict[int, str] = {}
        self._channels: dict[int, Topic] = {}
        with path.open("rb") as file:
            if not self._add_summary(file):
                self._scan(file)

    @property
    def topics(self) -> tuple[Topic, ...]:
        """Topics, in the order of the file."""
        return tuple(dict.fromkeys(self._channels.values()))

    def messages(self, names: Set[str]) -> Iterator[RecordedMessage]:
        """Yield the messages of some topics, in the order of the file."""
        with self._path.open("rb") as file:
            reader = StreamReader(file, validate_crcs=True, record_size_limit=_RECORD_MAX)
            try:
                for record in reader.records:
                    self._add(record)
                    if isinstance(record, Message):
                        topic = self._channels.get(record.channel_id)
                        if topic is not None and topic.name in names:
                            yield topic.name, record.data
            except Exception as error:  # mcap, lz4 and zstandard raise almost any type
                raise damaged(self._path, f"before byte {file.tell()}", error) from error

    def _add_summary(self, file: BinaryIO) -> bool:
        """Add the channels that the summary lists; False if there is no summary."""
        try:
            summary = SeekingReader(file, record_size_limit=_RECORD_MAX).get_summary()
        except Exception:  # a file that was truncated has no summary
            return False
        if summary is None or not summary.channels:
            return False
        counts = summary.statistics.channel_message_counts if summary.statistics else None
        for schema in summary.schemas.values():
            self._add(schema)
        for channel in summary.channels.values():
            if counts is None or counts.get(channel.id):
                self._add(channel)
        return True

    def _scan(self, file: BinaryIO) -> None:
        """Add the channels at the beginning of the file; an error ends the search."""
        file.seek(0)
        try:
            for record in StreamReader(file, record_size_limit=_RECORD_MAX).records:
                self._add(record)
                if file.tell() > SCAN_BYTES:
                    return
        except Exception:  # `messages` raises it again
            return

    def _add(self, record: McapRecord) -> None:
        if isinstance(record, Schema):
            self._kinds[record.id] = ros2_kind(record.name)
        elif isinstance(record, Channel) and record.message_encoding in _SERIALISED_AS_ROS1:
            kind = self._kinds.get(record.schema_id, "")
            is_ros1 = _SERIALISED_AS_ROS1[record.message_encoding]
            self._channels[record.id] = Topic(record.topic, kind, is_ros1)
