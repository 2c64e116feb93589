"""Event recordings of other people's tools in, and ours out.

`open_events` reads whatever format a file has, in chunks and in constant memory; `open_writer` and
`write_events` write what the ending of the name asks for, whole or not at all.
"""

from formats.errors import FormatError, MissingLibraryError
from formats.event_file import Chunk, EventFile, Found, open_events, read_events
from formats.identify import FORMATS
from formats.writers import ENDINGS, WRITERS, open_writer, write_events
from formats.writers.base import EventWriter

__all__ = [
    "ENDINGS",
    "FORMATS",
    "WRITERS",
    "Chunk",
    "EventFile",
    "EventWriter",
    "FormatError",
    "Found",
    "MissingLibraryError",
    "open_events",
    "open_writer",
    "read_events",
    "write_events",
]
