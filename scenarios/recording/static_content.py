"""Static content of a recording: 3-D scene, camera, parameters, colours and legends."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import rerun as rr

from flybench.events import Cause
from flybench.printable import printable
from scenarios.output.colours import OFF, ON, Rgb, rgb_of
from scenarios.recording import entities as at
from scenarios.recording.event_batches import class_id
from scenarios.styles.method_style import method_style
from sim import Crossing
from sim.truth.body_meshes import WORLD, BodyMesh, body_meshes

IMAGE_PLANE_M = 2.2
"""Distance of the image plane from the camera in the 3-D view (by eye)."""
EVENT_RADIUS_PX = 0.75
"""Radius of an event: more than half a pixel, so that neighbours leave no gap (by eye)."""
LINE_WIDTH_PT = 2.0
"""Width of a curve (by eye): visible on a slide."""
ON_TOP = 40.0
"""Draw order of boxes and markers; the viewer's default for points, such as events, is 30."""
_RATES = (
    (at.RATE_ON, "ON", ON),
    (at.RATE_OFF, "OFF", OFF),
    (at.RATE_NOISE, "noise", at.NOISE_RGB),
)
_MASK_CLASSES = [(0, "not the target", (0, 0, 0, 0)), (1, "target", (*at.TRUTH_RGB, 90))]


def log_static_content(
    stream: rr.RecordingStream, crossing: Crossing, methods: Mapping[str, at.MethodPaths]
) -> None:
    """Write everything that does not change with time."""
    log_static(stream, at.WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    for mesh in body_meshes(crossing.scene.model):
        log_static(stream, at.STREET if mesh.name == WORLD else body_path(mesh.name), _mesh(mesh))
    _log_camera(stream, crossing)
    _log_truth_styles(stream)
    for path in (at.ANGULAR_VELOCITY, at.TRUE_VELOCITY_X, at.TRUE_VELOCITY_Y):
        _log_curve(stream, path, "truth", at.TRUTH_RGB)
    log_styles(stream, methods)


def log_styles(stream: rr.RecordingStream, methods: Mapping[str, at.MethodPaths]) -> None:
    """Write colours and legends of events, event rates and methods; this needs no scene."""
    log_static(stream, at.EVENTS, _event_classes())
    log_static(stream, at.EVENTS, rr.Points2D.from_fields(radii=EVENT_RADIUS_PX))
    for path, name, rgb in _RATES:
        _log_curve(stream, path, name, rgb)
    for name, paths in methods.items():
        style = method_style(name)
        label = style.label if len(methods) > 1 else None
        _log_method_styles(stream, paths, rgb_of(style.colour), label)


def log_parameters(stream: rr.RecordingStream, parameters: Mapping[str, object]) -> None:
    """Write the parameters of a run as properties of the recording.

    Args:
        stream: recording to write to.
        parameters: parameters by name. "crossing.seed" becomes "seed" of the property "crossing"; a
            name without a dot belongs to "run". Numbers stay numbers, and other values become text.
            Parameters that are None are omitted.
    """
    groups: dict[str, dict[str, Any]] = {}
    for name, value in parameters.items():
        group, dot, key = name.partition(".")
        if value is not None:
            groups.setdefault(group if dot else "run", {})[key or name] = _plain(value)
    for group, values in groups.items():
        stream.send_property(group, rr.AnyValues(**values))


def log_static(stream: rr.RecordingStream, path: str, what: rr.AsComponents) -> None:
    """Write a component that is valid at all times."""
    stream.log(path, what, static=True, strict=True)


def body_path(name: str) -> str:
    """Return the entity path of a moving body, such as "vehicle/wheel_front_left"."""
    return f"{at.WORLD}/{name}"


def _plain(value: object) -> float | bool | str:
    """Convert numbers to float64, since a field keeps the type of its first value in a process."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, int | float | np.number):
        return float(value)
    return printable(str(value))


def _mesh(mesh: BodyMesh) -> rr.Mesh3D:
    return rr.Mesh3D(
        vertex_positions=mesh.vertices_m,
        vertex_normals=mesh.normals,
        vertex_colors=mesh.colours,
    )


def _log_camera(stream: rr.RecordingStream, crossing: Crossing) -> None:
    pose, intrinsics = crossing.scene.pose, crossing.intrinsics
    axes = np.stack([pose.right, -pose.up, pose.forward], axis=1)
    log_static(stream, at.CAMERA, rr.Transform3D(translation=pose.position_m, mat3x3=axes))
    pinhole = rr.Pinhole(
        focal_length=intrinsics.focal_px,
        width=intrinsics.width,
        height=intrinsics.height,
        image_plane_distance=IMAGE_PLANE_M,
        color=at.CAMERA_RGB,
    )
    log_static(stream, at.CAMERA, pinhole)


def _event_classes() -> rr.AnnotationContext:
    classes = []
    for cause in Cause:
        for on, name, rgb in ((False, "OFF", OFF), (True, "ON", ON)):
            signal = cause is Cause.SIGNAL
            label = name if signal else f"{name}, {cause.name.lower()}"
            colour = rgb if signal else tuple(round(part * at.NOISE_DIMMING) for part in rgb)
            classes.append((class_id(cause, on=on), label, colour))
    return rr.AnnotationContext(classes)


def _log_truth_styles(stream: rr.RecordingStream) -> None:
    """Write the colours of the ground truth in the images."""
    log_static(stream, at.TRUTH, rr.AnnotationContext(_MASK_CLASSES))
    for path in (at.TRUTH_BOX, at.PREVIEW_BOX):
        log_static(stream, path, _outline(at.TRUTH_RGB))
    log_static(stream, at.PREVIEW_CENTROID, _marker(at.TRUTH_RGB))
    log_static(stream, at.TRUE_DIRECTION, _lane())


def _log_method_styles(
    stream: rr.RecordingStream, paths: at.MethodPaths, rgb: Rgb, label: str | None
) -> None:
    """Write colours and legends of a method; the label is None if it is the only one."""
    log_static(stream, paths.roi, _outline(rgb))
    log_static(stream, paths.view_centre, _marker(rgb))
    log_static(stream, paths.direction, _lane())
    vertical_rgb = at.VERTICAL_RGB if label is None else rgb
    _log_curve(stream, paths.hs, label or "HS, rightward > 0", rgb)
    _log_curve(stream, paths.vs, label or "VS, downward > 0", vertical_rgb)
    _log_curve(stream, paths.velocity_x, label or "estimate", rgb)
    _log_curve(stream, paths.velocity_y, label or "estimate", rgb)


def _log_curve(stream: rr.RecordingStream, path: str, name: str, rgb: Rgb) -> None:
    log_static(stream, path, rr.SeriesLines(names=name, colors=rgb, widths=LINE_WIDTH_PT))


def _outline(rgb: Rgb) -> rr.Boxes2D:
    return rr.Boxes2D.from_fields(colors=rgb, radii=rr.Radius.ui_points(1.5), draw_order=ON_TOP)


def _marker(rgb: Rgb) -> rr.Points2D:
    return rr.Points2D.from_fields(colors=rgb, radii=rr.Radius.ui_points(4.0), draw_order=ON_TOP)


def _lane() -> rr.StateConfiguration:
    names, colours = list(at.DIRECTION_RGB), list(at.DIRECTION_RGB.values())
    labels = [f"{at.ARROW[name]} {name}" for name in names]
    return rr.StateConfiguration(values=names, labels=labels, colors=colours)
