"""What all errors share."""

import pytest

from flybench.errors import first_line


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (OSError("no room\nfor it"), "no room"),
        (OSError("\n \nno room"), "no room"),
        (OSError(), "OSError"),
        (ValueError("\n"), "ValueError"),
    ],
)
def test_the_first_line_is_never_empty(error: Exception, line: str) -> None:
    assert first_line(error) == line
