"""What the formats refuse."""

from __future__ import annotations

from flybench.errors import FlybenchError


class FormatError(FlybenchError):
    """An event file cannot be read or written: the file, where in it, why, and what to do."""


class MissingLibraryError(FormatError):
    """A library that a format needs is not installed."""

    def __init__(self, library: str, purpose: str) -> None:
        super().__init__(
            f"{purpose} needs the library {library}, which is not installed; install it with: "
            "pip install 'flybench[formats]', or in a clone: .venv/bin/pip install -e '.[formats]'"
        )
