"""Errors of the commands."""

from __future__ import annotations

from flybench.errors import FlybenchError


class ScenarioError(FlybenchError):
    """Base of all errors that the commands raise on bad input."""


class OutputError(ScenarioError):
    """An output file or folder cannot be written."""


class MethodError(ScenarioError):
    """A detector does not exist, or does not follow the protocol `detector.Detector`."""
