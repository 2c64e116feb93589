"""Write event recordings: one interface for all formats, and one module for each format."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from flybench.events import Events
from formats.chunk import Chunk
from formats.errors import FormatError
from formats.writers.aedat4 import Aedat4Writer
from formats.writers.base import EventWriter
from formats.writers.dsec import DsecWriter
from formats.writers.evt3 import Evt3Writer
from formats.writers.npz import NpzWriter
from formats.writers.rosbag2 import McapWriter, Rosbag2Writer
from formats.writers.text import CsvWriter, TextWriter

WRITERS: dict[str, type[EventWriter]] = {
    "aedat4": Aedat4Writer,
    "hdf5": DsecWriter,
    "evt3": Evt3Writer,
    "text": TextWriter,
    "csv": CsvWriter,
    "npz": NpzWriter,
    "mcap": McapWriter,
    "rosbag2": Rosbag2Writer,
}
"""Writer of each format, by the name of the format."""

ENDINGS = {
    ".aedat4": "aedat4",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".raw": "evt3",
    ".txt": "text",
    ".csv": "csv",
    ".npz": "npz",
    ".mcap": "mcap",
}
"""Format of a new file, by the ending of its name. A ROS 2 bag is a folder and has no ending."""


def open_writer(
    path: Path | str,
    *,
    width: int,
    height: int,
    format: str | None = None,  # noqa: A002  (the usual name of this parameter)
    overwrite: bool = True,
) -> EventWriter:
    """Start to write a recording.

    The file appears, complete, when the `with` block ends without an error.

    Args:
        path: path of the file.
        width: sensor columns [px].
        height: sensor rows [px].
        format: name of the format, one of `WRITERS`; None: the one that `ENDINGS` has for the
            ending of the path.
        overwrite: True to replace an existing file, False to refuse it.

    Raises:
        FormatError: there is no such format, or the file cannot be written.
        MissingLibraryError: a library is missing; the message states how to install it.
    """
    path = Path(path)
    name = format or ENDINGS.get(path.suffix.lower())
    if name is None:
        raise FormatError(
            f"{path} ends in {path.suffix or 'nothing'}. Allowed is one of {', '.join(ENDINGS)}. "
            "Choose another name."
        )
    if name not in WRITERS:
        raise FormatError(f"The format is {name!r}. Allowed is one of {', '.join(WRITERS)}.")
    return WRITERS[name](path, width=width, height=height, overwrite=overwrite)


def write_events(
    path: Path | str,
    chunks: Iterable[Chunk | Events],
    *,
    width: int,
    height: int,
    format: str | None = None,  # noqa: A002
) -> None:
    """Write chunks to a file, with frames, IMU samples and triggers if the format supports them.

    IMU samples and triggers before time 0 are left out.

    Args:
        path: path of the file; an existing file is replaced.
        chunks: chunks of a recording, or arrays of events, in order of time.
        width: sensor columns [px].
        height: sensor rows [px].
        format: name of the format; see `open_writer`.

    Raises:
        FormatError: there is no such format, or the file or the events cannot be written.
        MissingLibraryError: a library is missing; the message states how to install it.
    """
    with open_writer(path, width=width, height=height, format=format) as writer:
        for chunk in chunks:
            if not isinstance(chunk, Chunk):
                writer.write(chunk)
                continue
            writer.write(chunk.events)
            if writer.takes_frames:
                for frame in chunk.frames:
                    writer.write_frame(frame)
            if writer.takes_samples:
                writer.write_samples(chunk.imu[chunk.imu["t"] >= 0])
                writer.write_samples(chunk.triggers[chunk.triggers["t"] >= 0])
