"""Copy a section of a recording to a writer, in constant memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from formats import Chunk, EventFile, EventWriter, FormatError
from scenarios.convert.section import Counts, Section

_STEPS = 1000
"""Steps of the progress bar."""


@dataclass
class Totals:
    """Counts of one conversion.

    Attributes:
        read: what was read, up to the end of the section.
        outside_time: what was read and lies before or after the section.
        outside_crop: what of the rest lies outside the part of the sensor.
        written: what was written.
        damage: error message of a damaged file; empty: it is intact.
    """

    read: Counts = field(default_factory=Counts)
    outside_time: Counts = field(default_factory=Counts)
    outside_crop: Counts = field(default_factory=Counts)
    written: Counts = field(default_factory=Counts)
    damage: str = ""

    @property
    def unsupported(self) -> Counts:
        """What the new format does not contain."""
        return self.read - self.outside_time - self.outside_crop - self.written


def copy(
    file: EventFile,
    section: Section,
    writer: EventWriter,
    advance: Callable[[int, int], None],
    *,
    salvage: bool,
) -> Totals:
    """Copy a section of a recording and return the counts.

    Args:
        file: the recording; it is read no further than the section.
        section: what is copied.
        writer: where it goes.
        advance: function that is given the amount done and the total.
        salvage: True to copy what comes before the damage of a damaged file.

    Raises:
        FormatError: the file is damaged and `salvage` is False, or it cannot be written.
    """
    totals = Totals()
    for chunk in _chunks(file, totals) if salvage else file:
        in_time = section.in_time(chunk)
        part = section.in_crop(in_time)
        totals.read += Counts.of(chunk)
        totals.outside_time += Counts.of(chunk) - Counts.of(in_time)
        totals.outside_crop += Counts.of(in_time) - Counts.of(part)
        totals.written += _write(writer, part)
        share = file.read_share
        if share is not None:
            advance(round(share * _STEPS), _STEPS)
        if chunk.events.size and int(chunk.events["t"][-1]) >= section.to_us:
            break
    advance(_STEPS, _STEPS)
    return totals


def _chunks(file: EventFile, totals: Totals) -> Iterator[Chunk]:
    """Yield the chunks before the damage."""
    try:
        yield from file
    except FormatError as error:
        totals.damage = str(error)


def _write(writer: EventWriter, chunk: Chunk) -> Counts:
    """Write what the format takes of a chunk, and return the counts of that."""
    writer.write(chunk.events)
    frames = chunk.frames if writer.takes_frames else ()
    for frame in frames:
        writer.write_frame(frame)
    counts = []
    for samples in (chunk.imu, chunk.triggers):
        kept = samples[samples["t"] >= 0] if writer.takes_samples else samples[:0]
        if kept.size:
            writer.write_samples(kept)
        counts.append(kept.size)
    return Counts(chunk.events.size, len(frames), *counts)
