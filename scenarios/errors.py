"""Errors that the commands raise on bad input."""

from __future__ import annotations

from flybench.errors import FlybenchError


class ScenarioError(FlybenchError):
    """Base of all errors that the commands raise on bad input."""


class OutputError(ScenarioError):
    """Something cannot be written where it was asked to be."""


class MethodError(ScenarioError):
    """A detector does not exist, or does not obey the protocol `detector.Detector`."""
