"""Prophesee RAW (EVT 2.0 and 3.0) and DAT, decoded by faery."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from formats.columns import EventColumns, FileHeader, ParsedFile, ParsedItem, ReadOptions, Size
from formats.errors import FormatError, MissingLibraryError
from formats.identify import percent_header
from formats.prophesee_sensors import possible_sizes, stated_size

_HEADER_MAX = 1 << 20
_WORD_BYTES = {"evt2": 4, "evt3": 2}
_DAT_BYTES = 8
_LARGEST_EVT, _LARGEST_DAT = (1 << 11, 1 << 11), (1 << 14, 1 << 14)
"""Sizes that the bits of a coordinate allow [px]."""

_SHOWN = ("date", "sensor_name", "integrator_name", "plugin_name", "serial_number", "format", "evt")


def read_evt2(path: Path, options: ReadOptions) -> ParsedFile:
    """Read EVT 2.0: 4-byte words."""
    del options
    return _read_evt(path, "evt2")


def read_evt3(path: Path, options: ReadOptions) -> ParsedFile:
    """Read EVT 3.0: 2-byte words."""
    del options
    return _read_evt(path, "evt3")


def read_dat(path: Path, options: ReadOptions) -> ParsedFile:
    """Read DAT: a header, two bytes with the type and size of an event, and 8 bytes an event."""
    del options
    facts, start = _header(path)
    decoder = _decoder("dat", path, _LARGEST_DAT, None)
    if decoder.event_type not in ("2d", "cd"):
        raise FormatError(
            f"{path} contains events of the type {decoder.event_type}. Allowed is CD (contrast "
            "detection). Give the file of CD events."
        )
    shown = _shown(facts) | {"version": str(decoder.version)}
    packets = ((packet, packet["payload"] > 0) for packet in decoder)
    return file_header(facts, shown), _checked(path, packets, start + 2, _DAT_BYTES)


def file_header(facts: dict[str, str], shown: dict[str, str]) -> FileHeader:
    """Return the header of a Prophesee file; the size of the sensor is stated, implied or unknown.

    Args:
        facts: values of the header by keyword in lower case.
        shown: those to be displayed.
    """
    found = stated_size(facts)
    if found is None:
        return FileHeader(None, shown, possible_sizes=possible_sizes(facts))
    return FileHeader(found[0], shown, size_source=found[1])


def _read_evt(path: Path, version: str) -> ParsedFile:
    facts, start = _header(path)
    decoder = _decoder("evt", path, _LARGEST_EVT, version)
    if decoder.version != version:
        raise FormatError(
            f"{path} states the format {decoder.version}, but --format is {version}. Leave "
            "--format out."
        )
    packets = (
        (packet["events"], packet["events"]["on"]) for packet in decoder if "events" in packet
    )
    items = _checked(path, packets, start, _WORD_BYTES[version])
    return file_header(facts, _shown(facts)), items


def _decoder(module: str, path: Path, largest: Size, version: str | None) -> Any:
    """Open a file; `largest` is used where it does not state a size, which is checked later."""
    try:
        import faery
    except ImportError as error:
        raise MissingLibraryError("faery", "a Prophesee file") from error
    return getattr(faery.file_decoder, module).Decoder(path, largest, version)


def _header(path: Path) -> tuple[dict[str, str], int]:
    with path.open("rb") as file:
        return percent_header(file.read(_HEADER_MAX))


def _shown(facts: dict[str, str]) -> dict[str, str]:
    return {name: facts[name] for name in _SHOWN if facts.get(name)}


def _checked(path: Path, packets: Any, start: int, word: int) -> Iterator[ParsedItem]:
    """Yield the events of each packet, then check that the file ends after a complete word."""
    try:
        for events, on in packets:
            yield EventColumns(events["t"].astype(np.int64), events["x"], events["y"], on)
    except RuntimeError as error:
        if "overflow" not in str(error):
            raise
        raise FormatError(
            f"{path} states a size of its sensor that is too small: {error}. Allowed are events "
            "on the sensor. Correct the width and height in its header."
        ) from error
    length = path.stat().st_size
    extra = (length - start) % word
    if length < start or extra:
        raise FormatError(
            f"{path} ends within a {word}-byte word, at byte {length}. It was truncated; the "
            f"events before that were read. Remove the rest with: head -c {max(length - extra, 0)}"
        )
