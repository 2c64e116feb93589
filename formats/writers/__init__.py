"""Writing: one function for every format, one file a format."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from flybench.events import Events
from formats.errors import FormatError
from formats.event_file import Chunk
from formats.writers.aedat4 import Aedat4Writer
from formats.writers.base import EventWriter
from formats.writers.dsec import DsecWriter
from formats.writers.evt3 import Evt3Writer
from formats.writers.npz import NpzWriter
from formats.writers.text import CsvWriter, TextWriter

WRITERS: dict[str, type[EventWriter]] = {
    "aedat4": Aedat4Writer,
    "hdf5": DsecWriter,
    "evt3": Evt3Writer,
    "text": TextWriter,
    "csv": CsvWriter,
    "npz": NpzWriter,
}
"""The writer of each format that can be written, by its name."""

ENDINGS = {
    ".aedat4": "aedat4",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".raw": "evt3",
    ".txt": "text",
    ".csv": "csv",
    ".npz": "npz",
}
"""The format that a file's ending asks for."""


def open_writer(
    path: Path | str,
    *,
    width: int,
    height: int,
    format: str | None = None,  # noqa: A002  (what it is called everywhere)
) -> EventWriter:
    """Begin to write a recording; it is there, whole, when the `with` block has ended well.

    Args:
        path: where to; an earlier file there is replaced.
        width: sensor columns [px].
        height: sensor rows [px].
        format: one of `WRITERS`; None: what the ending asks for, one of `ENDINGS`.

    Raises:
        FormatError: no such format, or nothing can be written there.
        MissingLibraryError: a library is missing, with the command that installs it.
    """
    path = Path(path)
    name = format or ENDINGS.get(path.suffix.lower())
    if name is None:
        raise FormatError(
            f"{path} ends in {path.suffix or 'nothing'}; allowed is {', '.join(ENDINGS)}; rename it"
        )
    if name not in WRITERS:
        raise FormatError(f"the format is {name!r}; allowed is one of {', '.join(WRITERS)}")
    return WRITERS[name](path, width=width, height=height)


def write_events(
    path: Path | str,
    chunks: Iterable[Chunk | Events],
    *,
    width: int,
    height: int,
    format: str | None = None,  # noqa: A002
) -> None:
    """Write all chunks, with their frames where the format takes them, as `open_writer` says."""
    with open_writer(path, width=width, height=height, format=format) as writer:
        for chunk in chunks:
            if not isinstance(chunk, Chunk):
                writer.write(chunk)
                continue
            writer.write(chunk.events)
            if writer.takes_frames:
                for frame in chunk.frames:
                    writer.write_frame(frame)
