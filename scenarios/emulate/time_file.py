"""Text files with the time of each frame."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from fractions import Fraction
from pathlib import Path

from flybench.files import read_small_text
from scenarios.emulate.frame_times import FrameTimes, own_times
from scenarios.emulate.time_unit import Unit, guess_unit, in_us
from scenarios.errors import ScenarioError

ALLOWED = (
    "Allowed is one frame a line: a time, a time and the name of an image in either order, a "
    "number from 0 or 1 and a time, or a date with a time of day"
)
_NUMBER = re.compile(r"[+-]?(\d{1,30}(\.\d{0,30})?|\.\d{1,30})([eE][+-]?\d{1,2})?")
_DATE = re.compile(r"(\d{4}-\d\d-\d\d)[ T](\d\d:\d\d:\d\d)(\.\d+)?")
_UNIT = re.compile(r"[\[(](s|sec|seconds?|ms|us|µs|ns)[\])]|_(us|ns|ms|s)\b", re.IGNORECASE)


@dataclass(frozen=True)
class TimeTable:
    """Contents of a text file with times.

    Attributes:
        values: time of each line, in `unit`.
        names: path of the image of each line, as written; empty if the lines contain no names.
        unit: unit that the file states; None if it states none.
    """

    values: list[Fraction]
    names: list[str]
    unit: Unit | None


def read_time_file(file: Path) -> TimeTable:
    """Read a text file with one time a line. Lines that begin with # and a header may come first.

    Raises:
        ScenarioError: it is not such a file.
    """
    try:
        lines = read_small_text(file).removeprefix("\ufeff").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(
            f"{file} cannot be read as a text file with times ({error}). {ALLOWED}."
        ) from error
    numbered = [(k, line.strip()) for k, line in enumerate(lines, 1) if line.strip()]
    header = [line for _, line in numbered if line.startswith("#")]
    rows = [(k, line) for k, line in numbered if not line.startswith("#")]
    if rows and not _DATE.fullmatch(rows[0][1]) and not any(map(_is_number, _words(rows[0][1]))):
        header.append(rows.pop(0)[1])
    parsed = [_parse(file, k, line) for k, line in rows]
    kinds = {(name is None, is_date, len(numbers)) for name, is_date, numbers in parsed}
    if len(kinds) != 1:
        raise ScenarioError(f"{file} has no times, or lines of different kinds. {ALLOWED}.")
    names = [name for name, _, _ in parsed if name is not None]
    values = _column(file, [numbers for _, _, numbers in parsed])
    return TimeTable(values, names, "us" if parsed[0][1] else _stated_unit(header))


def times_of_frames(file: Path, count: int, unit: Unit | None) -> FrameTimes:
    """Return the times of frames that have no names, in the order of the lines of a text file.

    Raises:
        ScenarioError: not one time for each frame, or no valid times.
    """
    table = read_time_file(file)
    if len(table.values) != count:
        raise ScenarioError(
            f"{file} has {len(table.values)} times for {count} frames. There must be one time for "
            "each frame. Correct the file, or give a constant rate with --fps."
        )
    return table_times(file, table, [f"frame {k}" for k in range(count)], unit)


def table_times(
    file: Path, table: TimeTable, names: Sequence[str], unit: Unit | None
) -> FrameTimes:
    """Return the times of a table.

    Args:
        file: where they come from.
        table: the times, in the order of the frames.
        names: what each frame is called in error messages.
        unit: unit that the user states; None if not stated.

    Raises:
        ScenarioError: they are frame numbers, or not in order.
    """
    if unit is not None:
        chosen, reason = unit, "--time-unit"
    elif table.unit is not None:
        chosen, reason = table.unit, "as the file states"
    else:
        guessed = guess_unit(table.values, in_names=False) if len(table.values) > 1 else None
        if guessed is None:
            raise ScenarioError(
                f"{file} contains frame numbers, not times. Give the frames per second with --fps, "
                "or the unit with --time-unit if they are times."
            )
        chosen, reason = guessed
    times_us = in_us(table.values, chosen)
    times = own_times(times_us, names, f"{file.name}, in {chosen} ({reason})")
    return replace(times, file=file)


def _words(line: str) -> list[str]:
    return re.split(r"[,;\s]+", line.strip(",; \t"))


def _is_number(word: str) -> bool:
    return _NUMBER.fullmatch(word) is not None


def _parse(file: Path, number: int, line: str) -> tuple[str | None, bool, list[Fraction]]:
    """Return the image name, whether the time is a date, and the numbers of a line."""
    date = _DATE.fullmatch(line)
    if date is not None:
        try:
            return None, True, [_date_us(date)]
        except ValueError:
            raise ScenarioError(
                f"{file} has the line {number}: {line[:60]!r}. Allowed is a date and a time of "
                "day that exist, such as 2023-12-31 23:59:59.5. Correct the line."
            ) from None
    name, numbers = None, []
    for word in _words(line):
        if _is_number(word):
            numbers.append(Fraction(word))
        elif name is None:
            name = word
        else:
            raise ScenarioError(f"{file} has the line {number}: {line[:60]!r}. {ALLOWED}.")
    return name, False, numbers


def _date_us(date: re.Match[str]) -> Fraction:
    """Return the Unix time of a date in UTC [µs]; datetime itself has no nanoseconds.

    Raises:
        ValueError: there is no such date or time of day.
    """
    second = datetime.fromisoformat(f"{date[1]}T{date[2]}").replace(tzinfo=UTC)
    return (int(second.timestamp()) + Fraction(date[3] or 0)) * 1_000_000


def _column(file: Path, rows: list[list[Fraction]]) -> list[Fraction]:
    """Return the column of times; a first column may count the frames."""
    first = [row[0] for row in rows if row]
    if len(rows[0]) == 2 and [value - first[0] for value in first] == list(range(len(rows))):
        return [row[1] for row in rows]
    if len(rows[0]) != 1:
        raise ScenarioError(f"{file} has {len(rows[0])} numbers a line. {ALLOWED}.")
    return first


def _stated_unit(header: list[str]) -> Unit | None:
    for line in header:
        match = _UNIT.search(line)
        if match is not None:
            text = (match[1] or match[2]).lower().replace("µ", "u")
            return next(unit for unit in ("ms", "us", "ns", "s") if text.startswith(unit))
    return None
