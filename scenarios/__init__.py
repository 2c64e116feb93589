"""The commands of flybench, and all other code that combines several of its packages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flybench.lazy import lazy_names

if TYPE_CHECKING:
    from scenarios.errors import OutputError, ScenarioError
    from scenarios.pipeline.event_camera import (
        EventCamera,
        MotionWarning,
    )

_MODULES = {
    "scenarios.errors": (
        "OutputError",
        "ScenarioError",
    ),
    "scenarios.pipeline.event_camera": (
        "EventCamera",
        "MotionWarning",
    ),
}

__all__ = [
    "EventCamera",
    "MotionWarning",
    "OutputError",
    "ScenarioError",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy_names(__name__, _MODULES)
