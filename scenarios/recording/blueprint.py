"""How a recording looks when it is opened: light and events above, what is made of them below."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import rerun.blueprint as rrb

from flybench.direction import Direction
from scenarios.pipeline.registry import gives_velocity
from scenarios.recording import entities as at
from scenarios.recording.entities import MethodPaths
from sim import Crossing

EVENT_WINDOW_S = 0.02
"""Events of the last 20 ms are shown: at the paper's speeds, trails of 7 to 16 px."""
PLAYBACK_SPEED = 0.1
"""A crossing takes a second; a tenth of its speed lets the eye follow it."""
VELOCITY_PX_S = (-400.0, 1200.0)
"""Image velocities that the plot shows, along the true motion: half as much again as the paper's
fastest, 790 px/s, and some of the wrong sign."""
EYE_M, LOOK_AT_M = (-4.2, -12.2, 3.3), (-0.4, -2.8, 1.0)
"""The 3-D view from above and behind the camera, the near houses out of the way [m]."""
BACKDROP_RGB = (44, 54, 70)
"""Behind the 3-D scene, by day and by night: recordings opened together have one view."""

Methods = Mapping[str, MethodPaths]


@dataclass(frozen=True)
class _Seen:
    """What is looked at.

    Attributes:
        width, height: of the sensor [px].
        direction: of the true motion; None where nobody knows, and then no scene is there either.
        has_frames: whether there are APS frames.
    """

    width: int
    height: int
    direction: Direction | None = None
    has_frames: bool = True

    @property
    def has_truth(self) -> bool:
        return self.direction is not None

    @property
    def is_horizontal(self) -> bool:
        return self.direction in (None, Direction.RIGHT, Direction.LEFT)

    @property
    def is_positive(self) -> bool:
        """Whether the true motion is towards positive x or y."""
        return self.direction in (Direction.RIGHT, Direction.DOWN)


def blueprint(
    crossing: Crossing,
    methods: Methods,
    maps_of: str | None = None,
    *,
    lists_recordings: bool = False,
) -> rrb.Blueprint:
    """The default view of a recording of `crossing`; light and speed make no difference to it.

    The viewer has one view for all recordings that are opened together.

    Args:
        crossing: what is recorded.
        methods: what is compared, by name, in the order of their colours.
        maps_of: which of them has a fly's maps; None: none.
        lists_recordings: whether the panel is open in which one changes to another recording.
    """
    lens = crossing.intrinsics
    seen = _Seen(lens.width, lens.height, crossing.config.direction)
    return _blueprint(seen, methods, maps_of, lists_recordings=lists_recordings)


def stream_blueprint(
    width: int, height: int, methods: Methods, maps_of: str | None = None, *, has_frames: bool
) -> rrb.Blueprint:
    """The default view of events of which nobody knows the truth.

    Args:
        width: sensor columns [px].
        height: sensor rows [px].
        methods: what is compared, by name, in the order of their colours.
        maps_of: which of them has a fly's maps; None: none.
        has_frames: whether there are APS frames.
    """
    return _blueprint(_Seen(width, height, has_frames=has_frames), methods, maps_of)


def _blueprint(
    seen: _Seen, methods: Methods, maps_of: str | None, *, lists_recordings: bool = False
) -> rrb.Blueprint:
    views = [_overview(seen, methods, maps_of)]
    if maps_of is not None:
        views.append(_maps(seen, methods[maps_of]))
    return rrb.Blueprint(
        rrb.Tabs(*views) if len(views) > 1 else views[0],
        _TIME_PANEL,
        rrb.BlueprintPanel(state="expanded" if lists_recordings else "hidden"),
        rrb.SelectionPanel(state="hidden"),
    )


def _overview(seen: _Seen, methods: Methods, maps_of: str | None) -> rrb.Vertical:
    """What goes on a slide."""
    bounds = _bounds(seen)
    attending = methods[maps_of] if maps_of else next(iter(methods.values()), None)
    images = [_events(seen, bounds, attending)]
    if seen.has_truth:
        images.insert(0, _preview(bounds))
    if seen.has_frames:
        images.append(_aps(bounds))
    if maps_of is not None:
        images.append(_saliency(methods[maps_of], bounds))
    curves = rrb.Vertical(_responses(seen, methods), _velocities(seen, methods))
    lanes = _directions(seen, len(methods))
    rest = (
        rrb.Vertical(lanes, _scene(), row_shares=[2 + len(methods), 6]) if seen.has_truth else lanes
    )
    return rrb.Vertical(
        rrb.Horizontal(*images),
        rrb.Horizontal(curves, rest, column_shares=[55, 45]),
        row_shares=[386, 580] if len(images) == 4 else [506, 460],
        name="Overview",
    )


def _maps(seen: _Seen, paths: MethodPaths) -> rrb.Vertical:
    """What a fly makes of the events, map by map."""
    bounds = _bounds(seen)
    return rrb.Vertical(
        rrb.Horizontal(
            _map("ON surface", paths.on, bounds),
            _map("OFF surface", paths.off, bounds),
            _saliency(paths, bounds),
        ),
        rrb.Horizontal(
            *(_map(f"T4 + T5 {path.rpartition('/')[2]}", path, bounds) for path in paths.motion)
        ),
        row_shares=[58, 42],
        name="Inside the fly",
    )


def _bounds(seen: _Seen) -> rrb.VisualBounds2D:
    return rrb.VisualBounds2D(x_range=[0, seen.width], y_range=[0, seen.height])


def _scene() -> rrb.Spatial3DView:
    return rrb.Spatial3DView(
        name="Scene",
        origin=at.WORLD,
        contents=[at.STREET, f"{at.WORLD}/vehicle/**", at.CAMERA, at.APS],
        background=BACKDROP_RGB,
        line_grid=False,
        eye_controls=rrb.EyeControls3D(position=EYE_M, look_target=LOOK_AT_M, eye_up=(0, 0, 1)),
    )


def _preview(bounds: rrb.VisualBounds2D) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(
        name="Preview, true mask, box and centroid",
        origin=at.CAMERA,
        contents=[at.PREVIEW, at.TRUTH_MASK, at.PREVIEW_BOX, at.PREVIEW_CENTROID],
        visual_bounds=bounds,
    )


def _events(
    seen: _Seen, bounds: rrb.VisualBounds2D, attending: MethodPaths | None
) -> rrb.Spatial2DView:
    over = [] if attending is None else [attending.roi, attending.view_centre]
    boxes = "true box, region" if seen.has_truth else "region"
    return rrb.Spatial2DView(
        name=f"Events of {EVENT_WINDOW_S * 1e3:.0f} ms: ON red, OFF green; {boxes}",
        origin=at.CAMERA,
        contents=[at.EVENTS, *([at.TRUTH_BOX] if seen.has_truth else []), *over],
        background=(0, 0, 0),
        visual_bounds=bounds,
        # Boxes last until they move: only the events have a trail.
        overrides={at.EVENTS: _TRAIL},
    )


def _aps(bounds: rrb.VisualBounds2D) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(
        name="APS frame", origin=at.CAMERA, contents=[at.APS], visual_bounds=bounds
    )


def _saliency(paths: MethodPaths, bounds: rrb.VisualBounds2D) -> rrb.Spatial2DView:
    over = (paths.roi, paths.view_centre)
    return _map("Saliency, view centre, region", paths.saliency, bounds, over)


def _map(
    name: str, path: str, bounds: rrb.VisualBounds2D, over: tuple[str, ...] = ()
) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(
        name=name, origin=at.CAMERA, contents=[path, *over], visual_bounds=bounds
    )


def _responses(seen: _Seen, methods: Methods) -> rrb.View | rrb.Tabs:
    """One method: both axes in a plot. Several: a plot an axis, that of the true motion first."""
    if len(methods) <= 1:
        return _plot(seen, "Response of the detector", at.RESPONSE, axis_y=_RESPONSE_AXIS)
    plots = [
        _plot(seen, f"{name}, all methods", origin, axis_y=_RESPONSE_AXIS)
        for name, origin in (
            ("HS response, rightward > 0", at.HS),
            ("VS response, downward > 0", at.VS),
        )
    ]
    return rrb.Tabs(*_in_order(plots, horizontal=seen.is_horizontal))


def _velocities(seen: _Seen, methods: Methods) -> rrb.Tabs:
    """Image velocity, true and as methods give it; the event rate first where none gives one."""
    ends = VELOCITY_PX_S if seen.is_positive else tuple(-v for v in VELOCITY_PX_S[::-1])
    axis = rrb.ScalarAxis(range=ends) if seen.has_truth else None
    plots = [
        _plot(seen, f"Image velocity [px/s], {name} > 0", origin, axis_y=axis)
        for name, origin in (("rightward", at.IMAGE_VELOCITY_X), ("downward", at.IMAGE_VELOCITY_Y))
    ]
    images = _in_order(plots, horizontal=seen.is_horizontal)
    rate = _plot(seen, "Event rate [kev/s]", at.RATE)
    has_velocity = any(gives_velocity(method) for method in methods)
    if not seen.has_truth:
        return rrb.Tabs(*(images if has_velocity else ()), rate)
    turning = _plot(seen, "Angular velocity [rad/s]", at.ANGULAR_VELOCITY)
    if has_velocity:
        return rrb.Tabs(*images, turning, rate)
    return rrb.Tabs(rate, *images, turning)


def _directions(seen: _Seen, methods: int) -> rrb.StateTimelineView:
    whose = "method's" if methods == 1 else "methods'"
    name = f"Direction: the truth, and the {whose}" if seen.has_truth else "Direction"
    return rrb.StateTimelineView(name=name, origin=at.DIRECTION, time_view=_LINKED)


def _plot(
    seen: _Seen, name: str, origin: str, axis_y: rrb.ScalarAxis | None = None
) -> rrb.TimeSeriesView:
    """Curves over time, the legend where a right answer is not."""
    return rrb.TimeSeriesView(
        name=name,
        origin=origin,
        axis_x=_LINKED,
        axis_y=axis_y,
        plot_legend=rrb.PlotLegend(corner="RightBottom" if seen.is_positive else "RightTop"),
    )


def _in_order(plots: list[rrb.TimeSeriesView], *, horizontal: bool) -> list[rrb.TimeSeriesView]:
    """Of a horizontal and a vertical plot, that of the true motion first."""
    return plots if horizontal else plots[::-1]


_LINKED = rrb.TimeAxis(link="LinkToGlobal")
_RESPONSE_AXIS = rrb.ScalarAxis(range=(-1.1, 1.1))
_TRAIL = rrb.VisibleTimeRanges(
    rrb.VisibleTimeRange(
        at.TIMELINE,
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-EVENT_WINDOW_S),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
)
_TIME_PANEL = rrb.TimePanel(
    state="collapsed",
    timeline=at.TIMELINE,
    playback_speed=PLAYBACK_SPEED,
    play_state="playing",
    loop_mode="all",
)
