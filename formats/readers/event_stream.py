"""Event Stream (.es), decoded by faery; y counts upwards in it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from formats.columns import Columns, Head, Item, Options, Reading
from formats.errors import FormatError, MissingLibraryError


def read(path: Path, options: Options) -> Reading:
    """Events of a DVS, or the changes that an ATIS saw.

    Raises:
        FormatError: the events are of another type.
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
            f"{path} holds {decoder.event_type} events; allowed are those of a DVS or an ATIS"
        )
    says = {"version": str(decoder.version), "events of": decoder.event_type.upper()}
    return Head(decoder.dimensions, says), _items(decoder)


def _items(decoder: Any) -> Iterator[Item]:
    last_row = decoder.dimensions[1] - 1
    for events in decoder:
        if decoder.event_type == "atis":
            events = events[~events["exposure"]]
        on = events["polarity" if decoder.event_type == "atis" else "on"]
        yield Columns(events["t"].astype(np.int64), events["x"], last_row - events["y"], on)
