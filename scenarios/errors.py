"""Errors that the commands raise on bad input."""

from __future__ import annotations

import traceback
from pathlib import Path

from flybench.errors import FlybenchError


class ScenarioError(FlybenchError):
    """Base of all errors that the commands raise on bad input."""


class OutputError(ScenarioError):
    """A file or folder cannot be written where the user wants it."""


class MethodError(ScenarioError):
    """A detector does not exist, or does not follow the protocol `detector.Detector`."""


def describe(error: Exception) -> str:
    """Return an error as one line: its class, its message, and where it was raised."""
    first_line, *_ = [*str(error).splitlines(), ""]
    text = f"{type(error).__name__}: {first_line}"
    if isinstance(error, SyntaxError):  # its message names file and line
        return text
    *_, last = traceback.extract_tb(error.__traceback__)
    return f"{text} ({Path(last.filename).name}, line {last.lineno})"
