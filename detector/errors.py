"""What the detector refuses."""

from __future__ import annotations

from flybench.errors import EventError, FlybenchError


class DetectorError(FlybenchError):
    """Base of all errors that the detector raises on bad input."""


class DetectorConfigError(DetectorError):
    """A detector parameter is outside its range."""


class EventOrderError(DetectorError, EventError):
    """A time that a stream cannot go on with: it went back, or is no whole number of µs.

    It is an `EventError` too: one `except` clause catches every complaint about a stream.
    """


class StateError(DetectorError):
    """A saved state that does not belong to this detector."""


class FrameError(DetectorError):
    """What was passed is no frame of this sensor."""
