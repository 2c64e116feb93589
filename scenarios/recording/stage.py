"""What stands in a recording from the start: the 3-D scene, the camera, colours and legends."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
import rerun as rr

from flybench.events import Cause
from scenarios.recording import entities as at
from scenarios.recording.event_batches import class_id
from sim import Crossing
from sim.truth.body_meshes import WORLD, BodyMesh, body_meshes

IMAGE_PLANE_M = 2.2
"""How far in front of the camera its image hangs in the 3-D view (by eye)."""
EVENT_RADIUS_PX = 0.75
"""More than half a pixel, so that neighbouring events leave no gap (by eye)."""
LINE_WIDTH_PT = 2.0
"""Of a curve (by eye): seen on a slide."""
ON_TOP = 40.0
"""Draw order of boxes and marks; the viewer's own for points, such as events, is 30."""
_RATES = (
    (at.RATE_ON, "ON", at.ON_RGB),
    (at.RATE_OFF, "OFF", at.OFF_RGB),
    (at.RATE_NOISE, "of noise", at.NOISE_RGB),
)
_MASK_CLASSES = [(0, "not the target", (0, 0, 0, 0)), (1, "target", (*at.TRUTH_RGB, 90))]


def log_stage(
    stream: rr.RecordingStream, crossing: Crossing, methods: Mapping[str, at.MethodPaths]
) -> None:
    """Write all that does not change with time; methods in the order of their colours."""
    log_static(stream, at.WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    for mesh in body_meshes(crossing.scene.model):
        log_static(stream, at.STREET if mesh.name == WORLD else body_path(mesh.name), _mesh(mesh))
    _log_camera(stream, crossing)
    _log_truth_marks(stream)
    for path in (at.ANGULAR_VELOCITY, at.TRUE_VELOCITY_X, at.TRUE_VELOCITY_Y):
        _log_curve(stream, path, "truth", at.TRUTH_RGB)
    log_marks(stream, methods)


def log_marks(stream: rr.RecordingStream, methods: Mapping[str, at.MethodPaths]) -> None:
    """Write how events, their rate and what methods say look, which needs no scene."""
    log_static(stream, at.EVENTS, _event_classes())
    log_static(stream, at.EVENTS, rr.Points2D.from_fields(radii=EVENT_RADIUS_PX))
    for path, name, rgb in _RATES:
        _log_curve(stream, path, name, rgb)
    colours = itertools.cycle(at.METHOD_RGB)
    for (name, paths), rgb in zip(methods.items(), colours, strict=False):
        _log_method(stream, paths, rgb, name if len(methods) > 1 else None)


def log_parameters(stream: rr.RecordingStream, parameters: Mapping[str, object]) -> None:
    """Write a run's parameters as properties of the recording.

    Args:
        stream: to write to.
        parameters: by name; a name "crossing.seed" becomes "seed" of the property "crossing", one
            without a dot belongs to "run". Numbers stay numbers, all else is text; None is left
            out.
    """
    groups: dict[str, dict[str, Any]] = {}
    for name, value in parameters.items():
        group, dot, key = name.partition(".")
        if value is not None:
            groups.setdefault(group if dot else "run", {})[key or name] = _plain(value)
    for group, values in groups.items():
        stream.send_property(group, rr.AnyValues(**values))


def log_static(stream: rr.RecordingStream, path: str, what: rr.AsComponents) -> None:
    """Write something that holds at all times."""
    stream.log(path, what, static=True, strict=True)


def body_path(name: str) -> str:
    """Entity of a moving body, such as "vehicle/wheel_front_left"."""
    return f"{at.WORLD}/{name}"


def _plain(value: object) -> float | bool | str:
    """Numbers as float64, since a field keeps the type that the process first gave it."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, int | float | np.number):
        return float(value)
    return str(value)


def _mesh(mesh: BodyMesh) -> rr.Mesh3D:
    return rr.Mesh3D(
        vertex_positions=mesh.vertices_m,
        vertex_normals=mesh.normals,
        vertex_colors=mesh.colours,
    )


def _log_camera(stream: rr.RecordingStream, crossing: Crossing) -> None:
    pose, lens = crossing.scene.pose, crossing.intrinsics
    axes = np.stack([pose.right, -pose.up, pose.forward], axis=1)
    log_static(stream, at.CAMERA, rr.Transform3D(translation=pose.position_m, mat3x3=axes))
    pinhole = rr.Pinhole(
        focal_length=lens.focal_px,
        width=lens.width,
        height=lens.height,
        image_plane_distance=IMAGE_PLANE_M,
        color=at.METHOD_RGB[0],
    )
    log_static(stream, at.CAMERA, pinhole)


def _event_classes() -> rr.AnnotationContext:
    classes = []
    for cause in Cause:
        for on, name, rgb in ((False, "OFF", at.OFF_RGB), (True, "ON", at.ON_RGB)):
            signal = cause is Cause.SIGNAL
            label = name if signal else f"{name}, {cause.name.lower()}"
            colour = rgb if signal else tuple(round(part * at.NOISE_DIMMING) for part in rgb)
            classes.append((class_id(cause, on=on), label, colour))
    return rr.AnnotationContext(classes)


def _log_truth_marks(stream: rr.RecordingStream) -> None:
    """The looks of what is drawn over the images; the places come with time."""
    log_static(stream, at.TRUTH, rr.AnnotationContext(_MASK_CLASSES))
    for path in (at.TRUTH_BOX, at.PREVIEW_BOX):
        log_static(stream, path, _outline(at.TRUTH_RGB))
    log_static(stream, at.PREVIEW_CENTROID, _mark(at.TRUTH_RGB))
    log_static(stream, at.TRUE_DIRECTION, _lane())


def _log_method(
    stream: rr.RecordingStream, paths: at.MethodPaths, rgb: at.Rgb, name: str | None
) -> None:
    """The looks of one of several methods; without a name, of one that is alone."""
    log_static(stream, paths.roi, _outline(rgb))
    log_static(stream, paths.view_centre, _mark(rgb))
    log_static(stream, paths.direction, _lane())
    across = at.VERTICAL_RGB if name is None else rgb
    _log_curve(stream, paths.hs, name or "HS, rightward > 0", rgb)
    _log_curve(stream, paths.vs, name or "VS, downward > 0", across)
    _log_curve(stream, paths.velocity_x, name or "estimate", rgb)
    _log_curve(stream, paths.velocity_y, name or "estimate", rgb)


def _log_curve(stream: rr.RecordingStream, path: str, name: str, rgb: at.Rgb) -> None:
    log_static(stream, path, rr.SeriesLines(names=name, colors=rgb, widths=LINE_WIDTH_PT))


def _outline(rgb: at.Rgb) -> rr.Boxes2D:
    return rr.Boxes2D.from_fields(colors=rgb, radii=rr.Radius.ui_points(1.5), draw_order=ON_TOP)


def _mark(rgb: at.Rgb) -> rr.Points2D:
    return rr.Points2D.from_fields(colors=rgb, radii=rr.Radius.ui_points(4.0), draw_order=ON_TOP)


def _lane() -> rr.StateConfiguration:
    names, colours = list(at.DIRECTION_RGB), list(at.DIRECTION_RGB.values())
    labels = [f"{at.ARROW[name]} {name}" for name in names]
    return rr.StateConfiguration(values=names, labels=labels, colors=colours)
