"""Filters that remove noise from a stream of events, one file each."""

from __future__ import annotations

from collections.abc import Callable

from detector.denoise.background_activity import BackgroundActivityFilter
from detector.denoise.double_window import DoubleWindowFilter
from detector.denoise.event_filter import EventFilter
from detector.denoise.filtered_detector import FilteredDetector, filtered
from detector.denoise.spatio_temporal import SpatioTemporalFilter
from detector.denoise.time_surface import TimeSurfaceFilter

__all__ = [
    "FILTERS",
    "BackgroundActivityFilter",
    "DoubleWindowFilter",
    "EventFilter",
    "FilteredDetector",
    "SpatioTemporalFilter",
    "TimeSurfaceFilter",
    "filtered",
]

FILTERS: dict[str, Callable[..., EventFilter]] = {
    "baf": BackgroundActivityFilter,
    "stcf": SpatioTemporalFilter,
    "time-surface": TimeSurfaceFilter,
    "double-window": DoubleWindowFilter,
}
"""Classes of the filters by name; made with the keywords `width` and `height`."""
