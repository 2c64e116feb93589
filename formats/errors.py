"""Errors of reading and writing event files."""

from __future__ import annotations

from flybench.errors import FlybenchError


class FormatError(FlybenchError):
    """An event file cannot be read or written.

    The message names the file, the place in it where possible, the reason and the remedy.
    """


class MissingLibraryError(FormatError):
    """A library that a format needs is not installed."""

    def __init__(self, library: str, purpose: str) -> None:
        super().__init__(
            f"{purpose} needs the library {library}, which is not installed. Install it with: "
            "pip install 'flybench[formats]', or in a clone: .venv/bin/pip install -e '.[formats]'"
        )
