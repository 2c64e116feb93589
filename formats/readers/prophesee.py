"""Prophesee RAW (EVT 2.0 and 3.0) and DAT, decoded by faery."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from formats.columns import EventColumns, FileHeader, ParsedFile, ParsedItem, ReadOptions
from formats.errors import FormatError, MissingLibraryError
from formats.identify import percent_header

_HEADER_MAX = 1 << 20
_WORD_BYTES = {"evt2": 4, "evt3": 2}
_DAT_BYTES = 8
_SHOWN = ("date", "sensor_name", "integrator_name", "plugin_name", "serial_number", "format", "evt")


def read_evt2(path: Path, options: ReadOptions) -> ParsedFile:
    """Read EVT 2.0: 4-byte words."""
    return _read_evt(path, options, "evt2")


def read_evt3(path: Path, options: ReadOptions) -> ParsedFile:
    """Read EVT 3.0: 2-byte words."""
    return _read_evt(path, options, "evt3")


def read_dat(path: Path, options: ReadOptions) -> ParsedFile:
    """Read DAT: a header, two bytes with the type and size of an event, and 8 bytes an event."""
    facts, start = _header(path)
    decoder = _decoder("dat", path, options, None)
    if decoder.event_type not in ("2d", "cd"):
        raise FormatError(
            f"{path} contains events of the type {decoder.event_type}. Allowed is CD (contrast "
            "detection). Give the file of CD events."
        )
    shown = _shown(facts) | {"version": str(decoder.version)}
    packets = ((packet, packet["payload"] > 0) for packet in decoder)
    return FileHeader(decoder.dimensions, shown), _checked(path, packets, start + 2, _DAT_BYTES)


def _read_evt(path: Path, options: ReadOptions, version: str) -> ParsedFile:
    facts, start = _header(path)
    decoder = _decoder("evt", path, options, version)
    if decoder.version != version:
        raise FormatError(
            f"{path} states the format {decoder.version}, but --format is {version}. Leave "
            "--format out."
        )
    packets = (
        (packet["events"], packet["events"]["on"]) for packet in decoder if "events" in packet
    )
    return FileHeader(decoder.dimensions, _shown(facts)), _checked(
        path, packets, start, _WORD_BYTES[version]
    )


def _decoder(module: str, path: Path, options: ReadOptions, version: str | None) -> Any:
    try:
        import faery
    except ImportError as error:
        raise MissingLibraryError("faery", "a Prophesee file") from error
    try:
        return getattr(faery.file_decoder, module).Decoder(path, options.size, version)
    except RuntimeError as error:
        if "no size information" not in str(error):
            raise
        raise FormatError(
            f"{path} does not state the size of its sensor. State it with --size, such as --size "
            "1280x720."
        ) from error


def _header(path: Path) -> tuple[dict[str, str], int]:
    with path.open("rb") as file:
        return percent_header(file.read(_HEADER_MAX))


def _shown(facts: dict[str, str]) -> dict[str, str]:
    return {name: facts[name] for name in _SHOWN if facts.get(name)}


def _checked(path: Path, packets: Any, start: int, word: int) -> Iterator[ParsedItem]:
    """Yield the events of each packet, then check that the file ends after a complete word."""
    for events, on in packets:
        yield EventColumns(events["t"].astype(np.int64), events["x"], events["y"], on)
    length = path.stat().st_size
    extra = (length - start) % word
    if length < start or extra:
        raise FormatError(
            f"{path} ends within a {word}-byte word, at byte {length}. It was truncated; the "
            f"events before that were read. Remove the rest with: head -c {max(length - extra, 0)}"
        )
