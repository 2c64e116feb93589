"""What the emulator refuses."""


class EmulatorError(ValueError):
    """Base of all errors that the emulator raises on bad input."""


class SensorConfigError(EmulatorError):
    """A sensor parameter is outside its range."""


class FrameError(EmulatorError):
    """A luminance frame cannot be light: wrong shape, negative, not finite, or out of order."""


class FitError(EmulatorError):
    """What is known of a recording besides its events cannot be."""


class EventError(EmulatorError):
    """An event array is not a sorted stream of `EVENT_DTYPE` from this sensor."""
