"""Event Stream (.es), decoded by faery. In the file y points up; this reader flips it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from formats.columns import EventColumns, FileHeader, ParsedFile, ParsedItem, ReadOptions
from formats.errors import FormatError, MissingLibraryError


def read(path: Path, options: ReadOptions) -> ParsedFile:
    """Read events of a DVS, or change detections of an ATIS; its exposure events are skipped.

    Raises:
        FormatError: the file contains events of another type.
        MissingLibraryError: faery is not installed.
    """
    del options
    try:
        import faery
    except ImportError as error:
        raise MissingLibraryError("faery", "Event Stream") from error
    decoder = faery.file_decoder.es.Decoder(path, 0)
    if decoder.event_type not in ("dvs", "atis"):
        raise FormatError(
            f"{path} contains {decoder.event_type} events. Allowed are those of a DVS or an ATIS. "
            "Give a recording of one of these."
        )
    facts = {"version": str(decoder.version), "sensor type": decoder.event_type.upper()}
    return FileHeader(decoder.dimensions, facts), _items(decoder)


def _items(decoder: Any) -> Iterator[ParsedItem]:
    last_row = decoder.dimensions[1] - 1
    for events in decoder:
        if decoder.event_type == "atis":
            events = events[~events["exposure"]]
        on = events["polarity" if decoder.event_type == "atis" else "on"]
        yield EventColumns(events["t"].astype(np.int64), events["x"], last_row - events["y"], on)
