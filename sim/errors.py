"""Errors that the simulator raises on bad input."""

from __future__ import annotations

from flybench.errors import FlybenchError


class SimError(FlybenchError):
    """Base of all errors that the simulator raises on bad input."""


class SceneConfigError(SimError):
    """A scene parameter is outside its range."""


class RendererError(SimError, RuntimeError):
    """This machine cannot render, or the renderer lacks what was asked for."""
