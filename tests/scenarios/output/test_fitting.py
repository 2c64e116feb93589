"""Tables in narrow terminals."""

import io

import pytest
from rich.table import Table
from rich.text import Text

from scenarios.output.streams import SafeConsole

WORDS = ("contrast-maximisation", "12,345,678 events in 0.511 s", "99.0 % (98.9 to 99.1)")


def printed(table: Table, width: int) -> str:
    console = SafeConsole(width=width)
    console.file = io.StringIO()
    console.print(table)
    return str(console.file.getvalue())


def wide_table() -> Table:
    table = Table("method", "what was\nread", "correct after 100 ms", "ns", title="a title")
    for _ in range(2):
        table.add_row(*WORDS, "8.05e+04")
    return table


@pytest.mark.parametrize("width", [30, 40, 50, 60, 70, 80, 90, 120])
def test_no_word_is_broken_and_nothing_is_cut_off(width: int) -> None:
    shown = printed(wide_table(), width)
    words = shown.replace("│", " ").replace("┃", " ").split()
    for cell in (*WORDS, "8.05e+04"):
        assert set(cell.split()) <= set(words)
    assert "…" not in shown
    assert max(map(len, shown.splitlines())) <= width


def test_a_table_that_fits_is_printed_as_it_is() -> None:
    assert printed(wide_table(), 120).count("┃") == 10
    assert "┃" in printed(wide_table(), 70)


def test_a_row_without_room_becomes_lines() -> None:
    lines = printed(wide_table(), 40).splitlines()
    assert [line.rstrip() for line in lines[:4]] == [
        "a title",
        "method: contrast-maximisation",
        "what was read: 12,345,678 events in",
        "0.511 s",
    ]


def test_names_and_values_become_one_line_each() -> None:
    table = Table(show_header=False)
    table.add_row("file", "a-very-long-name-of-a-file.aedat4")
    table.add_row("verdict\x1b[2J", Text("right"))
    lines = [line.rstrip() for line in printed(table, 39).splitlines()]
    assert lines == ["file: a-very-long-name-of-a-file.aedat4", "verdict\\x1b[2J: right"]


def test_a_column_that_may_not_wrap_is_not_cut_off() -> None:
    table = Table(box=None)
    table.add_column("name", no_wrap=True)
    table.add_column("text")
    table.add_row("no wrapping here", "some words that may wrap")
    assert "no wrapping here" in printed(table, 30)
