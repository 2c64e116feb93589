"""What Prophesee's formats have in common, and RAW EVT 3.0, decoded by faery."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from formats.columns import Array, EventColumns, FileHeader, ParsedFile, ParsedItem, ReadOptions
from formats.errors import FormatError, MissingLibraryError
from formats.identify import percent_header, prophesee_format
from formats.prophesee_sensors import possible_sizes, stated_size

_HEADER_MAX = 1 << 20
_BLOCK = 1 << 17
_EVT3_BYTES = 2
_LARGEST = (1 << 11, 1 << 11)
"""Size that the bits of a coordinate of EVT 3.0 allow [px]."""

_SHOWN = (
    "date", "sensor_name", "integrator_name", "plugin_name", "system_id", "serial_number", "format",
    "evt", "version",
)  # fmt: skip


def read_evt3(path: Path, options: ReadOptions) -> ParsedFile:
    """Read EVT 3.0: 2-byte words.

    Raises:
        FormatError: the header states another format.
        MissingLibraryError: faery is not installed.
    """
    del options
    facts, start = check_version(path, "evt3")
    try:
        import faery
    except ImportError as error:
        raise MissingLibraryError("faery", "a Prophesee RAW file, EVT 3.0") from error
    decoder = faery.file_decoder.evt.Decoder(path, _LARGEST, "evt3")
    packets = (packet["events"] for packet in decoder if "events" in packet)
    return file_header(facts, shown_facts(facts)), _evt3_items(path, packets, start)


def check_version(path: Path, version: str) -> tuple[dict[str, str], int]:
    """Return the header of a RAW file and its length, if it does not state another version.

    Raises:
        FormatError: it does.
    """
    facts, start = percent_facts(path)
    stated = prophesee_format(facts)
    if stated not in ("", version):
        raise FormatError(
            f"{path} states the format {stated}, but --format is {version}. Leave --format out."
        )
    return facts, start


def percent_facts(path: Path) -> tuple[dict[str, str], int]:
    """Return the values of a header by keyword in lower case, and its length [bytes]."""
    with path.open("rb") as file:
        return percent_header(file.read(_HEADER_MAX))


def shown_facts(facts: dict[str, str]) -> dict[str, str]:
    """Return the values of a header that are displayed."""
    return {name: facts[name] for name in _SHOWN if facts.get(name)}


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


def read_words(path: Path, start: int, word: np.dtype[Any]) -> Iterator[Array]:
    """Yield the words of a file in blocks, then check that it ends after a complete word.

    Args:
        path: path of the file.
        start: position of the first word [bytes].
        word: dtype of a word.
    """
    with path.open("rb") as file:
        file.seek(start)
        while data := file.read(_BLOCK * word.itemsize):
            yield np.frombuffer(data, word, count=len(data) // word.itemsize)
    _check_end(path, start, word.itemsize)


def _evt3_items(path: Path, packets: Iterator[Any], start: int) -> Iterator[ParsedItem]:
    try:
        for events in packets:
            yield EventColumns(events["t"].astype(np.int64), events["x"], events["y"], events["on"])
    except RuntimeError as error:
        if "overflow" not in str(error):
            raise
        raise FormatError(
            f"{path} states a size of its sensor that is too small: {error}. Allowed are events "
            "on the sensor. Correct the width and height in its header."
        ) from error
    _check_end(path, start, _EVT3_BYTES)


def _check_end(path: Path, start: int, word: int) -> None:
    length = path.stat().st_size
    extra = (length - start) % word
    if length < start or extra:
        raise FormatError(
            f"{path} ends within a {word}-byte word, at byte {length}. It was truncated; the "
            f"events before that were read. Remove the rest with: head -c {max(length - extra, 0)}"
        )
