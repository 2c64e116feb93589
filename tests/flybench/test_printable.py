import pytest

from flybench.errors import EventError
from flybench.printable import html_table, printable


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a\tb\n", "a\tb\n"),
        ("346×260 px, 3 µs", "346×260 px, 3 µs"),
        ("\x1b[2Jgone", "\\x1b[2Jgone"),
        ("\x9b31m\r\x07", "\\x9b31m\\r\\x07"),
        ("exe\u202etxt.\udcff", "exe\\u202etxt.\\udcff"),
    ],
)
def test_control_characters_are_escaped(text: str, shown: str) -> None:
    assert printable(text) == shown


def test_a_table_in_html_is_escaped() -> None:
    table = html_table("a & b", {"<name>": "1\x1b"})
    for part in ("<b>a &amp; b</b>", "&lt;name&gt;</th>", "1\\x1b</td>"):
        assert part in table


def test_messages_of_errors_are_printable() -> None:
    assert str(EventError("the group \x1b[31m")) == "the group \\x1b[31m"
