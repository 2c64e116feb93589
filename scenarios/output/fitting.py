"""Tables that fit into the terminal without breaking a word."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from flybench.printable import printable


def fitted(console: Console, table: Table) -> RenderableType:
    """Return a table in which no word is broken and no cell is cut off.

    Rich narrows the widest columns first, even if it must break words there. If not even the
    longest words of all columns have room beside each other, each row becomes a list of lines.

    Args:
        console: where the table will be printed.
        table: the table. The widths of its columns are set, unless it has a width of its own.
    """
    if table.width is not None:
        return table
    measured = [table._measure_column(console, console.options, c) for c in table.columns]
    least = [
        found.maximum if column.no_wrap else found.minimum
        for column, found in zip(table.columns, measured, strict=True)
    ]
    wished = [found.maximum - low for found, low in zip(measured, least, strict=True)]
    room = console.width - table._extra_width - sum(least)
    if room < 0:
        return _lists(table)
    if sum(wished) > room:
        for n, share in _shares(wished, room).items():
            table.columns[n].width = least[n] + share - table._get_padding_width(n)
    return table


def _shares(wished: Sequence[int], room: int) -> dict[int, int]:
    """Return the share of each column in some room; those that want little get all of it."""
    shares: dict[int, int] = {}
    for n in sorted(range(len(wished)), key=wished.__getitem__):
        shares[n] = min(wished[n], room // (len(wished) - len(shares)))
        room -= shares[n]
    return shares


def _lists(table: Table) -> RenderableType:
    """Return title and rows of a table, with a line for each cell."""
    lines = [_text(table.title)] if table.title else []
    names = [_text(column.header).plain.replace("\n", " ") for column in table.columns]
    for n, row in enumerate(zip(*(column.cells for column in table.columns), strict=True)):
        pairs = list(zip(names, map(_text, row), strict=True))
        if not table.show_header and len(pairs) == 2:  # names and values
            pairs = [(pairs[0][1].plain, pairs[1][1])]
        elif n:
            lines.append(Text())
        lines += [Text.assemble(name, ": " if name else "", cell) for name, cell in pairs]
    return Group(*lines)


def _text(cell: RenderableType | None) -> Text:
    return cell if isinstance(cell, Text) else Text(printable(str(cell or "")))
