"""What stands in a recording from the start: the 3-D scene, the camera, colours and legends."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import rerun as rr

from emulator import Cause
from scenarios.recording import entities as at
from scenarios.recording.event_batches import class_id
from sim import Crossing
from sim.geometry import WORLD, BodyMesh, body_meshes

IMAGE_PLANE_M = 2.2
"""How far in front of the camera its image hangs in the 3-D view (by eye)."""
EVENT_RADIUS_PX = 0.75
"""More than half a pixel, so that neighbouring events leave no gap (by eye)."""
_MASK_CLASSES = [(0, "not the target", (0, 0, 0, 0)), (1, "target", (*at.TRUTH_RGB, 90))]


def log_stage(stream: rr.RecordingStream, crossing: Crossing) -> None:
    """Write all that does not change with time."""
    log_static(stream, at.WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    for mesh in body_meshes(crossing.scene.model):
        log_static(stream, at.STREET if mesh.name == WORLD else body_path(mesh.name), _mesh(mesh))
    _log_camera(stream, crossing)
    log_static(stream, at.EVENTS, _event_classes())
    log_static(stream, at.EVENTS, rr.Points2D.from_fields(radii=EVENT_RADIUS_PX))
    _log_marks(stream)
    _log_curves(stream)


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
        color=at.FLY_RGB,
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


def _log_marks(stream: rr.RecordingStream) -> None:
    """The looks of what is drawn over the images; the places come with time."""
    log_static(stream, at.TRUTH, rr.AnnotationContext(_MASK_CLASSES))
    box = rr.Boxes2D.from_fields(colors=at.TRUTH_RGB, radii=rr.Radius.ui_points(1.5))
    log_static(stream, at.TRUTH_BOX, box)
    log_static(stream, at.TRUTH_CENTROID, _mark(at.TRUTH_RGB))
    roi = rr.Boxes2D.from_fields(colors=at.FLY_RGB, radii=rr.Radius.ui_points(1.5))
    log_static(stream, at.ROI, roi)
    log_static(stream, at.VIEW_CENTRE, _mark(at.FLY_RGB))


def _mark(rgb: at.Rgb) -> rr.Points2D:
    return rr.Points2D.from_fields(colors=rgb, radii=rr.Radius.ui_points(4.0))


def _log_curves(stream: rr.RecordingStream) -> None:
    curves = (
        (at.HS, "HS, rightward > 0", at.FLY_RGB),
        (at.VS, "VS, downward > 0", at.VERTICAL_RGB),
        (at.ANGULAR_VELOCITY, "angular velocity [rad/s]", at.TRUTH_RGB),
        (at.IMAGE_VELOCITY_X, "x, rightward > 0 [px/s]", at.TRUTH_RGB),
        (at.IMAGE_VELOCITY_Y, "y, downward > 0 [px/s]", at.VERTICAL_RGB),
        (at.RATE_ON, "ON [kev/s]", at.ON_RGB),
        (at.RATE_OFF, "OFF [kev/s]", at.OFF_RGB),
        (at.RATE_NOISE, "of noise [kev/s]", at.NOISE_RGB),
    )
    for path, name, rgb in curves:
        log_static(stream, path, rr.SeriesLines(names=name, colors=rgb, widths=1.5))
    for path in (at.TRUE_DIRECTION, at.FLY_DIRECTION):
        names, colours = list(at.DIRECTION_RGB), list(at.DIRECTION_RGB.values())
        log_static(stream, path, rr.StateConfiguration(values=names, colors=colours))
