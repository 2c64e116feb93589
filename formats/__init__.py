"""Event recordings: read twelve formats of other tools and write six.

`open_events` reads a file of any format in chunks and in constant memory. `open_writer` and
`write_events` choose the format by the file's ending; the file appears only once it is complete.
"""

from formats.errors import FormatError, MissingLibraryError
from formats.event_file import Chunk, EventFile, EventStatistics, open_events, read_events
from formats.event_order import SORT_MAX_US
from formats.identify import FORMATS, identify_format
from formats.writers import ENDINGS, WRITERS, open_writer, write_events
from formats.writers.base import EventWriter

__all__ = [
    "ENDINGS",
    "FORMATS",
    "SORT_MAX_US",
    "WRITERS",
    "Chunk",
    "EventFile",
    "EventStatistics",
    "EventWriter",
    "FormatError",
    "MissingLibraryError",
    "identify_format",
    "open_events",
    "open_writer",
    "read_events",
    "write_events",
]
