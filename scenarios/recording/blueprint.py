"""How a recording looks when it is opened: what is seen on the right, what it means on the left."""

from __future__ import annotations

import rerun.blueprint as rrb

from scenarios.recording import entities as at
from sim import Crossing, Lighting

EVENT_WINDOW_S = 0.02
"""Events of the last 20 ms are shown: at the paper's speeds, trails of 7 to 16 px."""
PLAYBACK_SPEED = 0.1
"""A crossing takes a second; a tenth of its speed lets the eye follow it."""
EYE_M, LOOK_AT_M = (-6.0, -12.5, 4.2), (0.6, -2.8, 0.9)
"""The 3-D view from above and behind the camera, the near houses out of the way [m]."""
SKY_RGB = {
    Lighting.DAY: (92, 124, 160),
    Lighting.DUSK: (50, 60, 84),
    Lighting.NIGHT: (14, 16, 24),
}


def blueprint(crossing: Crossing, *, has_maps: bool = True) -> rrb.Blueprint:
    """The default view of a recording of `crossing`, with or without a fly's maps."""
    lens = crossing.intrinsics
    bounds = rrb.VisualBounds2D(x_range=[0, lens.width], y_range=[0, lens.height])
    left = rrb.Vertical(
        _scene(crossing),
        _responses(),
        _directions(),
        _velocity(),
        _rates(),
        row_shares=[8, 4, 3, 3, 3],
    )
    seen = rrb.Horizontal(_preview(bounds), _events(bounds), _aps(bounds))
    right = _with_maps(seen, bounds) if has_maps else _without_maps(bounds)
    return rrb.Blueprint(
        rrb.Horizontal(left, right, column_shares=[32, 68]),
        _time_panel(crossing),
        collapse_panels=True,
    )


def _without_maps(bounds: rrb.VisualBounds2D) -> rrb.Vertical:
    """Events with where the detector looks, large; light beneath."""
    return rrb.Vertical(
        _events(bounds, _ATTENTION),
        rrb.Horizontal(_preview(bounds), _aps(bounds)),
        row_shares=[60, 40],
    )


def _with_maps(seen: rrb.Horizontal, bounds: rrb.VisualBounds2D) -> rrb.Vertical:
    return rrb.Vertical(
        seen,
        rrb.Horizontal(
            _map("ON surface", at.SURFACE_ON, bounds),
            _map("OFF surface", at.SURFACE_OFF, bounds),
            _map("Saliency, view centre, region of interest", at.SALIENCY, bounds, _ATTENTION),
        ),
        rrb.Horizontal(
            *(_map(f"T4 + T5 {path.rpartition('/')[2]}", path, bounds) for path in at.MOTION)
        ),
        row_shares=[353, 353, 272],
    )


_ATTENTION = (at.ROI, at.VIEW_CENTRE)


def _scene(crossing: Crossing) -> rrb.Spatial3DView:
    return rrb.Spatial3DView(
        name="Scene",
        origin=at.WORLD,
        contents=[at.STREET, f"{at.WORLD}/vehicle/**", at.CAMERA, at.APS],
        background=SKY_RGB[crossing.config.lighting],
        line_grid=False,
        eye_controls=rrb.EyeControls3D(position=EYE_M, look_target=LOOK_AT_M, eye_up=(0, 0, 1)),
    )


def _preview(bounds: rrb.VisualBounds2D) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(
        name="Preview, true mask, box and centroid",
        origin=at.CAMERA,
        contents=[at.PREVIEW, at.TRUTH_MASK, at.TRUTH_BOX, at.TRUTH_CENTROID],
        visual_bounds=bounds,
    )


def _events(bounds: rrb.VisualBounds2D, over: tuple[str, ...] = ()) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(
        name=f"Events of the last {EVENT_WINDOW_S * 1e3:.0f} ms: ON red, OFF green",
        origin=at.CAMERA,
        contents=[at.EVENTS, *over],
        background=(0, 0, 0),
        visual_bounds=bounds,
        time_ranges=rrb.VisibleTimeRange(
            at.TIMELINE,
            start=rrb.TimeRangeBoundary.cursor_relative(seconds=-EVENT_WINDOW_S),
            end=rrb.TimeRangeBoundary.cursor_relative(),
        ),
    )


def _aps(bounds: rrb.VisualBounds2D) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(
        name="APS frame", origin=at.CAMERA, contents=[at.APS], visual_bounds=bounds
    )


def _map(
    name: str, path: str, bounds: rrb.VisualBounds2D, over: tuple[str, ...] = ()
) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(
        name=name, origin=at.CAMERA, contents=[path, *over], visual_bounds=bounds
    )


def _responses() -> rrb.TimeSeriesView:
    return _plot("Response of the detector", at.RESPONSE, axis_y=rrb.ScalarAxis(range=(-1.1, 1.1)))


def _directions() -> rrb.StateTimelineView:
    return rrb.StateTimelineView(name="Direction", origin=at.DIRECTION, time_view=_LINKED)


def _velocity() -> rrb.Tabs:
    return rrb.Tabs(
        _plot("True angular velocity", at.ANGULAR_VELOCITY),
        _plot("True image velocity", at.IMAGE_VELOCITY),
    )


def _rates() -> rrb.TimeSeriesView:
    return _plot("Events", at.RATE)


def _plot(name: str, origin: str, axis_y: rrb.ScalarAxis | None = None) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        name=name,
        origin=origin,
        axis_x=_LINKED,
        axis_y=axis_y,
        plot_legend=rrb.PlotLegend(corner="RightTop"),
    )


_LINKED = rrb.TimeAxis(link="LinkToGlobal")


def _time_panel(crossing: Crossing) -> rrb.TimePanel:
    """Play what happens while the vehicle is in view, slowly, over and over."""
    lead_ns = round(crossing.config.lead_s * 1e9)
    seen = rrb.components.AbsoluteTimeRange(lead_ns, crossing.duration_us * 1000 - lead_ns)
    return rrb.TimePanel(
        state="collapsed",
        timeline=at.TIMELINE,
        playback_speed=PLAYBACK_SPEED,
        play_state="playing",
        loop_mode="selection",
        time_selection=seen,
    )
