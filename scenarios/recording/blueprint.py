"""Default layout of a recording in the viewer: images above, estimates over time below."""

from __future__ import annotations

import rerun.blueprint as rrb

from scenarios.recording import entities as at
from scenarios.recording.entities import MethodPaths
from scenarios.recording.views import (
    Methods,
    ViewOptions,
    direction_view,
    events_view,
    frames_view,
    image_bounds,
    map_view,
    preview_view,
    response_views,
    saliency_view,
    scene_view,
    velocity_views,
)
from sim import Crossing

PLAYBACK_SPEED = 0.1
"""A crossing takes a second; at a tenth of its speed the eye can follow it."""


def blueprint(
    crossing: Crossing,
    methods: Methods,
    maps_of: str | None = None,
    *,
    lists_recordings: bool = False,
) -> rrb.Blueprint:
    """Return the default layout for a recording of a crossing.

    It does not depend on lighting or speed, because the viewer uses one layout for all recordings
    that are opened together.

    Args:
        crossing: crossing that is recorded.
        methods: entity paths of the methods, by name.
        maps_of: name of the method that has a fly's maps; None: no method has maps.
        lists_recordings: True to open the panel in which the user chooses a recording.
    """
    size = crossing.intrinsics
    options = ViewOptions(size.width, size.height, crossing.config.direction)
    return _blueprint(options, methods, maps_of, lists_recordings=lists_recordings)


def stream_blueprint(
    width: int, height: int, methods: Methods, maps_of: str | None = None, *, has_frames: bool
) -> rrb.Blueprint:
    """Return the default layout for a recording without ground truth.

    Args:
        width: sensor columns [px].
        height: sensor rows [px].
        methods: entity paths of the methods, by name.
        maps_of: name of the method that has a fly's maps; None: no method has maps.
        has_frames: True if there are APS frames.
    """
    return _blueprint(ViewOptions(width, height, has_frames=has_frames), methods, maps_of)


def _blueprint(
    options: ViewOptions, methods: Methods, maps_of: str | None, *, lists_recordings: bool = False
) -> rrb.Blueprint:
    views = [_overview(options, methods, maps_of)]
    if maps_of is not None:
        views.append(_maps(options, methods[maps_of]))
    return rrb.Blueprint(
        rrb.Tabs(*views) if len(views) > 1 else views[0],
        _TIME_PANEL,
        rrb.BlueprintPanel(state="expanded" if lists_recordings else "hidden"),
        rrb.SelectionPanel(state="hidden"),
    )


def _overview(options: ViewOptions, methods: Methods, maps_of: str | None) -> rrb.Vertical:
    """Return the tab with all images and curves."""
    bounds = image_bounds(options)
    attention = methods[maps_of] if maps_of else next(iter(methods.values()), None)
    images = [events_view(options, bounds, attention)]
    if options.has_truth:
        images.insert(0, preview_view(bounds))
    if options.has_frames:
        images.append(frames_view(bounds))
    if maps_of is not None:
        images.append(saliency_view(methods[maps_of], bounds))
    curves = rrb.Vertical(response_views(options, methods), velocity_views(options, methods))
    lanes = direction_view(options, len(methods))
    rest = (
        rrb.Vertical(lanes, scene_view(), row_shares=[2 + len(methods), 6])
        if options.has_truth
        else lanes
    )
    return rrb.Vertical(
        rrb.Horizontal(*images),
        rrb.Horizontal(curves, rest, column_shares=[55, 45]),
        row_shares=[386, 580] if len(images) == 4 else [506, 460],
        name="Overview",
    )


def _maps(options: ViewOptions, paths: MethodPaths) -> rrb.Vertical:
    """Return the tab with the fly's maps."""
    bounds = image_bounds(options)
    return rrb.Vertical(
        rrb.Horizontal(
            map_view("ON surface", paths.on, bounds),
            map_view("OFF surface", paths.off, bounds),
            saliency_view(paths, bounds),
        ),
        rrb.Horizontal(
            *(map_view(f"T4 + T5 {path.rpartition('/')[2]}", path, bounds) for path in paths.motion)
        ),
        row_shares=[58, 42],
        name="Inside the fly",
    )


_TIME_PANEL = rrb.TimePanel(
    state="collapsed",
    timeline=at.TIMELINE,
    playback_speed=PLAYBACK_SPEED,
    play_state="playing",
    loop_mode="all",
)
