"""Digests of events and frames read from files of every format."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from formats import ENDINGS, Chunk, open_events, write_events
from tests.digests.detectors import HEIGHT, WIDTH, stream
from tests.digests.exact import Case
from tests.formats.sample_files import FILE_MAKERS, make_file, random_events


def round_trip(ending: str) -> Any:
    """Return the events and frames read from a file, and the facts from its header."""
    chunks = [Chunk(output.events, output.aps_frames) for output in stream()[:100]]
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"events{ending}"
        write_events(path, chunks, width=WIDTH, height=HEIGHT)
        with open_events(path) as file:
            read = list(file)
            return read, file.statistics, file.format, file.width, file.height, file.origin_us


def of_others(name: str) -> Any:
    """Return the same for a file that another program's format describes."""
    with (
        TemporaryDirectory() as folder,
        open_events(make_file(Path(folder), name, random_events())) as file,
    ):
        read = list(file)
        return read, file.statistics, file.format, file.width, file.height, file.origin_us


CASES: dict[str, Case] = {
    f"files.round_trip{ending}": Case(partial(round_trip, ending)) for ending in ENDINGS
} | {f"files.of_others.{name}": Case(partial(of_others, name)) for name in FILE_MAKERS}
