"""Views of a recording: images, curves over time, direction lanes and the 3-D scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import rerun.blueprint as rrb

from flybench.direction import Direction
from scenarios.pipeline.registry import gives_velocity
from scenarios.recording import entities as at
from scenarios.recording.entities import MethodPaths

EVENT_WINDOW_S = 0.02
"""Time for which an event is shown; at the paper's speeds, trails are 7 to 16 px long."""
VELOCITY_PX_S = (-400.0, 1200.0)
"""Range of the plot of image velocity along the true motion: up to one and a half times the paper's
fastest, 790 px/s, and some negative values."""
EYE_M, LOOK_AT_M = (-4.2, -12.2, 3.3), (-0.4, -2.8, 1.0)
"""Viewpoint and target of the 3-D view [m]: above and behind the camera, where no house is in the
way."""
BACKDROP_RGB = (44, 54, 70)
"""Background of the 3-D view, by day and by night: recordings opened together share one layout."""

Methods = Mapping[str, MethodPaths]


@dataclass(frozen=True)
class ViewOptions:
    """What a recording holds, as far as the layout depends on it.

    Attributes:
        width: sensor columns [px].
        height: sensor rows [px].
        direction: direction of the true motion; None if there is no ground truth and no scene.
        has_frames: True if there are APS frames.
    """

    width: int
    height: int
    direction: Direction | None = None
    has_frames: bool = True

    @property
    def has_truth(self) -> bool:
        """True if there is a ground truth, and so a preview and a scene."""
        return self.direction is not None

    @property
    def is_horizontal(self) -> bool:
        """True if the true motion is horizontal or unknown."""
        return self.direction in (None, Direction.RIGHT, Direction.LEFT)

    @property
    def is_positive(self) -> bool:
        """True if the true motion is in the direction of positive x or y."""
        return self.direction in (Direction.RIGHT, Direction.DOWN)


def image_bounds(options: ViewOptions) -> rrb.VisualBounds2D:
    """Return the bounds that show the whole image."""
    return rrb.VisualBounds2D(x_range=[0, options.width], y_range=[0, options.height])


def scene_view() -> rrb.Spatial3DView:
    """Return the 3-D view of the street, all moving objects and the camera."""
    return rrb.Spatial3DView(
        name="Scene",
        origin=at.WORLD,
        contents=[f"{at.WORLD}/**", f"- {at.CAMERA}/**", at.CAMERA, at.APS],
        background=BACKDROP_RGB,
        line_grid=False,
        eye_controls=rrb.EyeControls3D(position=EYE_M, look_target=LOOK_AT_M, eye_up=(0, 0, 1)),
    )


def preview_view(bounds: rrb.VisualBounds2D) -> rrb.Spatial2DView:
    """Return the colour preview with the true target."""
    return rrb.Spatial2DView(
        name="Preview, true mask, box and centroid",
        origin=at.CAMERA,
        contents=[at.PREVIEW, at.TRUTH_MASK, at.PREVIEW_BOX, at.PREVIEW_CENTROID],
        visual_bounds=bounds,
    )


def events_view(
    options: ViewOptions, bounds: rrb.VisualBounds2D, attention: MethodPaths | None
) -> rrb.Spatial2DView:
    """Return the view of the latest events, with the true box and the region of one method."""
    over = [] if attention is None else [attention.roi, attention.view_centre]
    boxes = "true box, region" if options.has_truth else "region"
    return rrb.Spatial2DView(
        name=f"Events of {EVENT_WINDOW_S * 1e3:.0f} ms: ON blue, OFF orange; {boxes}",
        origin=at.CAMERA,
        contents=[at.EVENTS, *([at.TRUTH_BOX] if options.has_truth else []), *over],
        background=(0, 0, 0),
        visual_bounds=bounds,
        # Only events have a trail; a box is shown until it moves.
        overrides={at.EVENTS: _TRAIL},
    )


def frames_view(bounds: rrb.VisualBounds2D) -> rrb.Spatial2DView:
    """Return the view of the APS frames."""
    return rrb.Spatial2DView(
        name="APS frame", origin=at.CAMERA, contents=[at.APS], visual_bounds=bounds
    )


def saliency_view(paths: MethodPaths, bounds: rrb.VisualBounds2D) -> rrb.Spatial2DView:
    """Return the view of a fly's saliency map, with its view centre and region."""
    over = (paths.roi, paths.view_centre)
    return map_view("Saliency, view centre, region", paths.saliency, bounds, over)


def map_view(
    name: str, path: str, bounds: rrb.VisualBounds2D, over: tuple[str, ...] = ()
) -> rrb.Spatial2DView:
    """Return the view of one map, with the entities `over` drawn on top."""
    return rrb.Spatial2DView(
        name=name, origin=at.CAMERA, contents=[path, *over], visual_bounds=bounds
    )


def response_views(options: ViewOptions, methods: Methods) -> rrb.View | rrb.Tabs:
    """Return one plot for one method; for several, one plot per axis, that of the motion first."""
    if len(methods) <= 1:
        return _plot(options, "Response of the detector", at.RESPONSE, axis_y=_RESPONSE_AXIS)
    plots = [
        _plot(options, f"{name}, all methods", origin, axis_y=_RESPONSE_AXIS)
        for name, origin in (
            ("HS response, rightward > 0", at.HS),
            ("VS response, downward > 0", at.VS),
        )
    ]
    return rrb.Tabs(*_in_order(plots, horizontal=options.is_horizontal))


def velocity_views(options: ViewOptions, methods: Methods) -> rrb.Tabs:
    """Return tabs with image velocity, angular velocity and event rate.

    The event rate comes first if no method gives velocities.
    """
    limits = VELOCITY_PX_S if options.is_positive else tuple(-v for v in VELOCITY_PX_S[::-1])
    axis = rrb.ScalarAxis(range=limits) if options.has_truth else None
    plots = [
        _plot(options, f"Image velocity [px/s], {name} > 0", origin, axis_y=axis)
        for name, origin in (("rightward", at.IMAGE_VELOCITY_X), ("downward", at.IMAGE_VELOCITY_Y))
    ]
    image_plots = _in_order(plots, horizontal=options.is_horizontal)
    rate = _plot(options, "Event rate [kev/s]", at.RATE)
    has_velocity = any(gives_velocity(method) for method in methods)
    if not options.has_truth:
        return rrb.Tabs(*(image_plots if has_velocity else ()), rate)
    angular = _plot(options, "Angular velocity [rad/s]", at.ANGULAR_VELOCITY)
    if has_velocity:
        return rrb.Tabs(*image_plots, angular, rate)
    return rrb.Tabs(rate, *image_plots, angular)


def direction_view(options: ViewOptions, methods: int) -> rrb.StateTimelineView:
    """Return the lanes with the true and the estimated directions over time."""
    name = "Direction"
    if options.has_truth:
        name += ": truth and method" + ("" if methods == 1 else "s")
    return rrb.StateTimelineView(name=name, origin=at.DIRECTION, time_view=_LINKED)


def _plot(
    options: ViewOptions, name: str, origin: str, axis_y: rrb.ScalarAxis | None = None
) -> rrb.TimeSeriesView:
    """Return a plot over time, with the legend away from the curve of a correct response."""
    return rrb.TimeSeriesView(
        name=name,
        origin=origin,
        axis_x=_LINKED,
        axis_y=axis_y,
        plot_legend=rrb.PlotLegend(corner="RightBottom" if options.is_positive else "RightTop"),
    )


def _in_order(plots: list[rrb.TimeSeriesView], *, horizontal: bool) -> list[rrb.TimeSeriesView]:
    """Return a horizontal and a vertical plot, with the axis of the true motion first."""
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
