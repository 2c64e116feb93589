"""ROS 2 bags: a SQLite file, or a folder with metadata.yaml and SQLite or MCAP files."""

from __future__ import annotations

from collections.abc import Iterator, Set
from pathlib import Path, PurePath

import zstandard
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader
from ruamel.yaml import YAML

from formats.errors import FormatError
from formats.readers.ros.bags import Bag, RecordedMessage, Topic, damaged, ros2_kind
from formats.readers.ros.mcap_file import McapFile

METADATA = "metadata.yaml"
_MCAP = b"\x89MCAP0\r\n"
_SQLITE = b"SQLite format 3\0"
_ZSTD = b"\x28\xb5\x2f\xfd"


class SqliteBag:
    """One SQLite file of a ROS 2 bag (.db3)."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._reader = Sqlite3Reader(path.absolute())
        try:
            self._reader.open()
        except Exception as error:  # apsw raises almost any type
            raise damaged(path, "in its tables", error) from error

    @property
    def topics(self) -> tuple[Topic, ...]:
        """Topics with messages, in the order of the file."""
        return tuple(
            Topic(item.topic, ros2_kind(item.msgtype), is_ros1=False)
            for item in self._reader.connections
            if item.msgcount
        )

    def messages(self, names: Set[str]) -> Iterator[RecordedMessage]:
        """Yield the messages of some topics, in order of the time at which they arrived."""
        wanted = [item for item in self._reader.connections if item.topic in names]
        count = 0
        try:
            for connection, _, data in self._reader.messages(wanted) if wanted else ():
                yield connection.topic, _uncompressed(data)
                count += 1
        except Exception as error:
            raise damaged(self._path, f"after message {count}", error) from error


class Rosbag2Folder:
    """A folder with metadata.yaml, which lists its files."""

    def __init__(self, path: Path) -> None:
        self._bags = [open_storage(file) for file in _listed_files(path)]

    @property
    def topics(self) -> tuple[Topic, ...]:
        """Topics of all files."""
        return tuple(dict.fromkeys(topic for bag in self._bags for topic in bag.topics))

    def messages(self, names: Set[str]) -> Iterator[RecordedMessage]:
        """Yield the messages of some topics, one file after the other."""
        for bag in self._bags:
            yield from bag.messages(names)


def open_storage(path: Path) -> Bag:
    """Open a file of a ROS 2 bag.

    Raises:
        FormatError: it is missing, compressed as a whole or of another format.
    """
    if not path.is_file():
        raise FormatError(
            f"{path} is missing or not a file, but {METADATA} lists it. Copy the bag again."
        )
    with path.open("rb") as file:
        head = file.read(16)
    if head == _SQLITE:
        return SqliteBag(path)
    if head.startswith(_MCAP):
        return McapFile(path)
    if head.startswith(_ZSTD):
        raise FormatError(
            f"{path} is compressed by zstd. Unpack it with unzstd first, and give what comes out."
        )
    raise FormatError(
        f"{path} begins with {head[:8]!r}. Allowed are SQLite and MCAP files. Copy the bag again."
    )


def _listed_files(folder: Path) -> list[Path]:
    path = folder / METADATA
    try:
        content = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
        names = content["rosbag2_bagfile_information"]["relative_file_paths"]
        files = [folder / PurePath(name).name for name in names]
    except Exception as error:  # the parser raises almost any type
        raise damaged(path, "and does not list the files of the bag", error) from error
    if not files:
        raise FormatError(f"{path} lists no files. Copy the bag again.")
    return files


def _uncompressed(data: bytes) -> bytes:
    """Return a message, uncompressed if the bag has compressed each message by itself."""
    if not data.startswith(_ZSTD):
        return data
    return zstandard.ZstdDecompressor().decompressobj().decompress(data)
