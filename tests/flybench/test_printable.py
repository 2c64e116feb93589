import pytest

from flybench.errors import EventError
from flybench.printable import printable


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


def test_messages_of_errors_are_printable() -> None:
    assert str(EventError("the group \x1b[31m")) == "the group \\x1b[31m"
