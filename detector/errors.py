"""Errors that detectors raise on bad input."""

from __future__ import annotations

from flybench.errors import EventError, FlybenchError


class DetectorError(FlybenchError):
    """Base of all errors that a detector raises on bad input."""


class DetectorConfigError(DetectorError):
    """A parameter of a detector has the wrong type or is out of range."""


class EventOrderError(DetectorError, EventError):
    """A time goes back, or is not a whole number of µs in the allowed range.

    It is also an `EventError`, so that one `except` clause catches every error about a stream.
    """


class StateError(DetectorError):
    """A saved state is damaged, or belongs to another detector."""


class FrameError(DetectorError):
    """A value is not a frame of this sensor."""
