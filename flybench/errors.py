"""The base of all errors that flybench raises on bad input, and those that every package shares."""

from __future__ import annotations

from flybench.printable import printable


class FlybenchError(ValueError):
    """Base of all errors that flybench raises on bad input; its message states what to do.

    Control characters in the message are escaped: it may quote a file, and terminals obey them.
    """

    def __init__(self, *args: object) -> None:
        super().__init__(*(printable(a) if isinstance(a, str) else a for a in args))


def message_of(error: BaseException) -> str:
    """Return the message of an error; empty if the error of another program cannot state it."""
    try:
        return str(error)
    except Exception:
        return ""


def first_line(error: BaseException) -> str:
    """Return the first line of an error's message; the class of the error if there is none."""
    lines = (line for line in message_of(error).splitlines() if line.strip())
    return next(lines, type(error).__name__)


class EventError(FlybenchError):
    """An event array is not a sorted stream of `EVENT_DTYPE` from this sensor."""
