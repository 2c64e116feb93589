"""Bags as sources of serialised messages: one class for each container."""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeAlias

from flybench.errors import first_line
from formats.errors import FormatError

SCAN_BYTES = 1 << 26
"""How far a file without an index is searched for its topics (assumed) [bytes]."""

RecordedMessage: TypeAlias = tuple[str, bytes]
"""Name of a topic, and a serialised message."""


@dataclass(frozen=True)
class Topic:
    """A topic of a bag.

    Attributes:
        name: its name.
        kind: type of its messages, as in ROS 2, such as "sensor_msgs/msg/Image".
        is_ros1: True if its messages are serialised as in ROS 1.
    """

    name: str
    kind: str
    is_ros1: bool


class Bag(Protocol):
    """A file or folder of messages."""

    @property
    def topics(self) -> tuple[Topic, ...]:
        """Topics with messages that may be decoded, in the order of the file."""
        ...

    def messages(self, names: Set[str]) -> Iterator[RecordedMessage]:
        """Yield the messages of the topics with these names, in the order they were recorded."""
        ...


def ros2_kind(kind: str) -> str:
    """Return the name that ROS 2 gives a type of message, such as "a/msg/B" for "a/B"."""
    package, _, name = kind.rpartition("/")
    return kind if "/" in package or not package else f"{package}/msg/{name}"


def damaged(path: Path, where: str, error: Exception) -> FormatError:
    """Return the error for a container that ends early or cannot be decoded.

    Args:
        path: path of the file.
        where: place in the file, such as "at byte 1234".
        error: what the decoder raised.
    """
    why = first_line(error)
    if isinstance(error, MemoryError):
        why = "a record needs more than the 1 GB of memory that a parser may use"
    return FormatError(
        f"{path} is truncated or damaged {where} ({why}). The messages before that were read. Copy "
        "it again from where it was recorded."
    )
