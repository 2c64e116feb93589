"""Prophesee RAW (EVT 2.0 and 3.0) and DAT, decoded by faery."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from formats.columns import Columns, Head, Item, Options, Reading
from formats.errors import FormatError, MissingLibraryError
from formats.identify import percent_header

_HEADER_MAX = 1 << 20
_WORD_BYTES = {"evt2": 4, "evt3": 2}
_DAT_BYTES = 8
_SHOWN = ("date", "sensor_name", "integrator_name", "plugin_name", "serial_number", "format", "evt")


def read_evt2(path: Path, options: Options) -> Reading:
    """EVT 2.0: words of 4 bytes."""
    return _read_evt(path, options, "evt2")


def read_evt3(path: Path, options: Options) -> Reading:
    """EVT 3.0: words of 2 bytes."""
    return _read_evt(path, options, "evt3")


def read_dat(path: Path, options: Options) -> Reading:
    """DAT: a header, two bytes of type and size, and 8 bytes an event."""
    facts, start = _header(path)
    decoder = _decoder("dat", path, options, None)
    if decoder.event_type not in ("2d", "cd"):
        raise FormatError(
            f"{path} holds events of the type {decoder.event_type}; allowed is CD, of contrast "
            "detection; give the file of CD events"
        )
    says = _says(facts) | {"version": str(decoder.version)}
    packets = ((packet, packet["payload"] > 0) for packet in decoder)
    return Head(decoder.dimensions, says), _checked(path, packets, start + 2, _DAT_BYTES)


def _read_evt(path: Path, options: Options, version: str) -> Reading:
    facts, start = _header(path)
    decoder = _decoder("evt", path, options, version)
    if decoder.version != version:
        raise FormatError(
            f"{path} says that it is {decoder.version}, not {version}; leave out --format"
        )
    packets = (
        (packet["events"], packet["events"]["on"]) for packet in decoder if "events" in packet
    )
    return Head(decoder.dimensions, _says(facts)), _checked(
        path, packets, start, _WORD_BYTES[version]
    )


def _decoder(module: str, path: Path, options: Options, version: str | None) -> Any:
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
            f"{path} does not say its sensor's size; give it with --size, as 1280x720"
        ) from error


def _header(path: Path) -> tuple[dict[str, str], int]:
    with path.open("rb") as file:
        return percent_header(file.read(_HEADER_MAX))


def _says(facts: dict[str, str]) -> dict[str, str]:
    return {name: facts[name] for name in _SHOWN if facts.get(name)}


def _checked(path: Path, packets: Any, start: int, word: int) -> Iterator[Item]:
    """The packets; then a complaint if the file ends within a word."""
    for events, on in packets:
        yield Columns(events["t"].astype(np.int64), events["x"], events["y"], on)
    length = path.stat().st_size
    extra = (length - start) % word
    if length < start or extra:
        raise FormatError(
            f"{path} ends within a word of {word} bytes, at byte {length}; it was cut; what comes "
            f"before was read; keep that with: head -c {max(length - extra, 0)}"
        )
