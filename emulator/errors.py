"""Errors that the emulator raises on bad input."""

from __future__ import annotations

from flybench.errors import FlybenchError


class EmulatorError(FlybenchError):
    """Base of all errors that the emulator raises on bad input."""


class SensorConfigError(EmulatorError):
    """A sensor parameter is outside its range, or of another type."""


class FrameError(EmulatorError):
    """A luminance frame is invalid: wrong shape, negative, not finite, or out of order in time."""


class FitError(EmulatorError):
    """The size, duration or drift that is given for a recording is impossible."""
