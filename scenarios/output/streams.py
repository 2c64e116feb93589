"""The standard streams: whose output goes where, and characters that a terminal cannot show."""

from __future__ import annotations

import codecs
import io
import os
import sys
import unicodedata
from contextlib import suppress
from typing import Any, TextIO

from rich.console import Console
from rich.table import Table
from rich.text import Text

from flybench.printable import printable
from scenarios.output.fitting import fitted
from scenarios.output.log import log_complaint, log_printed

_PLAIN = {
    "→": ">",
    "←": "<",
    "↑": "^",
    "↓": "v",
    "×": "x",
    "µ": "u",
    "–": "-",
    "−": "-",
    "—": "-",
    "…": ".",
    "≤": "<=",
    "≥": ">=",
    "·": "*",
    "°": "o",
    "•": "*",
    "╭": "+",
    "╮": "+",
    "╰": "+",
    "╯": "+",
    "─": "-",
    "│": "|",
}
"""ASCII text for characters that contain no ASCII letter; of the same width if it is readable."""
_WIDE = 1_000
_ERRORS = "flybench"
"""Name of our handler of characters that the encoding of a stream lacks."""


class _Own:
    """The stream of our own output, once `claim_output` has taken it; None before."""

    stream: TextIO | None = None


def prepare_streams() -> None:
    """Make the standard streams safe to write to.

    Print a similar ASCII character where the encoding of a terminal lacks one, and open the null
    device in place of a closed stream, so that no file of ours gets its descriptor.
    """
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free descriptor
    codecs.register_error(_ERRORS, _plain)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=_ERRORS)


def claim_output() -> None:
    """Keep standard output for our own output, until the process ends.

    Anything else that is printed goes to standard error from now on: by Python code, by C code that
    writes to file descriptor 1, and by processes that are started.
    """
    own = sys.__stdout__
    if _Own.stream is not None or own is None or own is not sys.stdout:
        return
    own.flush()
    descriptor = os.dup(own.fileno())
    _Own.stream = os.fdopen(descriptor, "w", encoding=own.encoding, errors=own.errors)
    os.dup2(2, own.fileno())
    sys.stdout = sys.stderr
    sys.__stdout__ = sys.stderr  # type: ignore[misc,assignment]


def own_output() -> TextIO:
    """Return the stream for what a command prints."""
    return _Own.stream or sys.stdout


class SafeConsole(Console):
    """A console for our own output that prints text as it is.

    It escapes control characters and knows no markup, because texts may come from files.
    """

    def __init__(self, *, stderr: bool = False, width: int | None = None) -> None:
        """Create a console.

        Args:
            stderr: True to print on standard error.
            width: width of the output [characters]; None: that of the terminal.
        """
        file = None if stderr else own_output()
        super().__init__(file=file, stderr=stderr, width=width, markup=False, emoji=False)

    def print(self, *objects: Any, **options: Any) -> None:
        """Print as `Console.print` does; tables break no word."""
        super().print(
            *(fitted(self, item) if isinstance(item, Table) else item for item in objects),
            **options,
        )

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a text as the console prints it; tables use this for their cells, too."""
        return super().render_str(printable(text), **options)


def table_width() -> int | None:
    """Return the width of wide tables: that of the terminal, or in a file whatever they need."""
    is_closed = own_output() is None
    return None if not is_closed and own_output().isatty() else _WIDE


def say(text: str) -> None:
    """Print a line of our own output, with control characters escaped."""
    log_printed(text)
    print(printable(text), file=own_output())


def complain(text: str) -> None:
    """Print a line on standard error, such as an error; it may be closed."""
    log_complaint(text)
    note(text)


def note(text: str) -> None:
    """Print a line on standard error that is no complaint, such as the progress; not logged."""
    with suppress(OSError):
        print(f"flybench: {printable(text)}", file=sys.stderr, flush=True)


def discard_output() -> None:
    """Discard the rest of our output, because its reader has closed it."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, own_output().fileno())
    os.close(null)


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_similar, error.object[error.start : error.end])), error.end


def _similar(character: str) -> str:
    """Return ASCII text that looks like a character, or "?"."""
    if character in _PLAIN:
        return _PLAIN[character]
    name = unicodedata.name(character, "")
    if name.startswith("GREEK"):
        return name.split()[-1].lower()
    letters = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    return letters or "?"
