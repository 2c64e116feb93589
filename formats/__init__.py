"""Event recordings: read sixteen formats of other tools and write eight.

`open_events` reads a file of any format in chunks and in constant memory. `open_writer` and
`write_events` choose the format by the file's ending; the file appears only once it is complete.
"""

from formats.chunk import Chunk, EventStatistics
from formats.errors import FormatError, MissingLibraryError
from formats.event_file import EventFile, open_events, read_events
from formats.event_order import SORT_MAX_US
from formats.identify import FORMATS, identify_format
from formats.samples import IMU_DTYPE, TRIGGER_DTYPE, TriggerKind
from formats.time_unit import UNITS_US, unit_us
from formats.writers import ENDINGS, WRITERS, open_writer, write_events
from formats.writers.base import EventWriter

__all__ = [
    "ENDINGS",
    "FORMATS",
    "IMU_DTYPE",
    "SORT_MAX_US",
    "TRIGGER_DTYPE",
    "UNITS_US",
    "WRITERS",
    "Chunk",
    "EventFile",
    "EventStatistics",
    "EventWriter",
    "FormatError",
    "MissingLibraryError",
    "TriggerKind",
    "identify_format",
    "open_events",
    "open_writer",
    "read_events",
    "unit_us",
    "write_events",
]
