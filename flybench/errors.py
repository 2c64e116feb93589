"""The base of all errors that flybench raises on bad input, and those that every package shares."""

from __future__ import annotations


class FlybenchError(ValueError):
    """Base of all errors that flybench raises on bad input; its message states what to do."""


class EventError(FlybenchError):
    """An event array is not a sorted stream of `EVENT_DTYPE` from this sensor."""
