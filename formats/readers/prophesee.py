"""What Prophesee's formats have in common, and RAW EVT 3.0.

flybench has its own decoder of EVT 3.0 because faery 0.7.1 gives a late event the time of the one
before it, without an error.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from formats.columns import Array, FileHeader, ParsedFile, ParsedItem, ReadOptions
from formats.errors import FormatError
from formats.identify import percent_header, prophesee_format
from formats.prophesee_sensors import possible_sizes, stated_size
from formats.readers.ros.evt3 import Evt3Decoder
from formats.samples import ParsedSamples

_HEADER_MAX = 1 << 20
_BLOCK = 1 << 17
_BACK_MAX = 1 << 11
"""Largest step back of the high part of the time that is no overflow: half its period."""

_SHOWN = (
    "date", "sensor_name", "integrator_name", "plugin_name", "system_id", "serial_number", "format",
    "evt", "version",
)  # fmt: skip


def read_evt3(path: Path, options: ReadOptions) -> ParsedFile:
    """Read events and triggers of EVT 3.0: 2-byte words.

    Raises:
        FormatError: the header states another format.
    """
    del options
    facts, start = check_version(path, "evt3")
    return file_header(facts, shown_facts(facts)), _evt3_items(path, start)


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


def _evt3_items(path: Path, start: int) -> Iterator[ParsedItem]:
    decoder = Evt3Decoder(back_max=_BACK_MAX)
    for words in read_words(path, start, np.dtype("<u2")):
        events, triggers = decoder.decode(words.tobytes())
        yield events
        if triggers.size:
            yield ParsedSamples(triggers)


def _check_end(path: Path, start: int, word: int) -> None:
    length = path.stat().st_size
    extra = (length - start) % word
    if length < start or extra:
        raise FormatError(
            f"{path} ends within a {word}-byte word, at byte {length}. It was truncated; the "
            f"events before that were read. Remove the rest with: head -c {max(length - extra, 0)}"
        )
