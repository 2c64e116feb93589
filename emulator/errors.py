"""Errors that the emulator raises on bad input."""

from __future__ import annotations

from flybench.errors import FlybenchError


class EmulatorError(FlybenchError):
    """Base of all errors that the emulator raises on bad input."""


class SensorConfigError(EmulatorError):
    """A sensor parameter is outside its range."""


class FrameError(EmulatorError):
    """A luminance frame cannot be light: wrong shape, negative, not finite, or out of order."""


class FitError(EmulatorError):
    """What is known of a recording besides its events cannot be."""
