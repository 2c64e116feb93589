"""Errors that the commands raise on bad input."""

from __future__ import annotations

import sysconfig
import traceback
from pathlib import Path

from flybench.errors import FlybenchError, message_of


class ScenarioError(FlybenchError):
    """Base of all errors that the commands raise on bad input."""


class OutputError(ScenarioError):
    """A file or folder cannot be written where the user wants it."""


class MethodError(ScenarioError):
    """A detector does not exist, or does not follow the protocol `detector.Detector`."""


_SHOWN = 300
"""Most characters of another program's message that are shown."""
_LIBRARIES = tuple(sysconfig.get_paths()[name] for name in ("stdlib", "purelib", "platlib"))


def describe(error: BaseException) -> str:
    """Return an error as one line: its class, its message, shortened, and where it was raised.

    The place is the last one outside of installed libraries, if there is one.
    """
    message, *_ = [*message_of(error).strip().splitlines(), ""]
    if len(message) > _SHOWN:
        message = f"{message[:_SHOWN]}..."
    text = f"{type(error).__name__}: {message}" if message else type(error).__name__
    places = traceback.extract_tb(error.__traceback__)
    if isinstance(error, SyntaxError) or not places:  # the former names file and line itself
        return text
    own = [place for place in places if not place.filename.startswith(_LIBRARIES)]
    last = (own or places)[-1]
    return f"{text} ({Path(last.filename).name}, line {last.lineno})"


def is_interrupt(error: BaseException | None) -> bool:
    """Return True if Ctrl-C caused the error: numba turns it into a SystemError."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None
