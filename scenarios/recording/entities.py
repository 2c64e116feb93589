"""Entity paths, colours and names in a recording."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

import rerun as rr

from scenarios.output.colours import Rgb
from scenarios.styles.method_style import method_style

TIMELINE: Final = "time"
"""Name of the only time line: time since the start of the sequence."""

WORLD: Final = "world"
STREET: Final = f"{WORLD}/street"
CAMERA: Final = f"{WORLD}/camera"
"""A pinhole camera. Entities below it are in sensor pixels; (0, 0) is the outer corner."""
PREVIEW: Final = f"{CAMERA}/preview"
APS: Final = f"{CAMERA}/aps"
EVENTS: Final = f"{CAMERA}/events"
TRUTH: Final = f"{CAMERA}/truth"
TRUTH_MASK: Final = f"{TRUTH}/mask"
TRUTH_BOX: Final = f"{TRUTH}/box"
PREVIEW_BOX: Final = f"{TRUTH}/preview_box"
PREVIEW_CENTROID: Final = f"{TRUTH}/preview_centroid"
"""Mask, box and centroid at the times of the preview, which has a lower rate than the truth."""
METHODS: Final = f"{CAMERA}/methods"
"""Regions, view centres and maps of each method; see `paths_of`."""

DIRECTION: Final = "direction"
TRUE_DIRECTION: Final = f"{DIRECTION}/0_truth"
"""The viewer sorts lanes by path and shows the path, so it has a number and the method's label."""
RESPONSE: Final = "response"
HS: Final = f"{RESPONSE}/hs"
VS: Final = f"{RESPONSE}/vs"
ANGULAR_VELOCITY: Final = "velocity/angular"
IMAGE_VELOCITY: Final = "velocity/image"
IMAGE_VELOCITY_X: Final = f"{IMAGE_VELOCITY}/x"
IMAGE_VELOCITY_Y: Final = f"{IMAGE_VELOCITY}/y"
TRUE_VELOCITY_X: Final = f"{IMAGE_VELOCITY_X}/truth"
TRUE_VELOCITY_Y: Final = f"{IMAGE_VELOCITY_Y}/truth"
RATE: Final = "event_rate"
RATE_ON: Final = f"{RATE}/on"
RATE_OFF: Final = f"{RATE}/off"
RATE_NOISE: Final = f"{RATE}/noise"


@dataclass(frozen=True)
class MethodPaths:
    """Entity paths of one method.

    Attributes:
        direction: lane of the estimated direction; its path has the label of the method.
        hs: curve of the normalised horizontal response.
        vs: curve of the normalised vertical response.
        velocity_x: curve of the image velocity [px/s], for a method that gives velocities.
        velocity_y: curve of the vertical image velocity [px/s].
        roi: region of interest, in the image.
        view_centre: view centre, in the image.
        on: map of a fly's ON surface.
        off: map of a fly's OFF surface.
        motion: a fly's motion maps, in the order of `FlyMaps.motion`.
        saliency: a fly's saliency map.
    """

    direction: str
    hs: str
    vs: str
    velocity_x: str
    velocity_y: str
    roi: str
    view_centre: str
    on: str
    off: str
    motion: tuple[str, ...]
    saliency: str


def paths_of(method: str, number: int) -> MethodPaths:
    """Return the entity paths of a method.

    Args:
        method: name of the method.
        number: its index in the recording, from 0.
    """
    part = rr.escape_entity_path_part(method)
    images = f"{METHODS}/{part}"
    return MethodPaths(
        direction=f"{DIRECTION}/{number + 1}_{lane_name(method)}",
        hs=f"{HS}/{part}",
        vs=f"{VS}/{part}",
        velocity_x=f"{IMAGE_VELOCITY_X}/{part}",
        velocity_y=f"{IMAGE_VELOCITY_Y}/{part}",
        roi=f"{images}/roi",
        view_centre=f"{images}/view_centre",
        on=f"{images}/on",
        off=f"{images}/off",
        motion=tuple(f"{images}/motion/{name}" for name in ("right", "left", "up", "down")),
        saliency=f"{images}/saliency",
    )


def lane_name(method: str) -> str:
    """Return the label of a method as part of a path that the viewer shows without escapes."""
    words = re.findall(r"[\w.-]+", method_style(method).label)
    return rr.escape_entity_path_part("_".join(words))


NOISE_RGB: Final[Rgb] = (150, 150, 160)
TRUTH_RGB: Final[Rgb] = (255, 214, 64)
CAMERA_RGB: Final[Rgb] = (92, 190, 255)
"""Colour of the camera in the 3-D view."""
VERTICAL_RGB: Final[Rgb] = (150, 150, 160)
"""Colour of the vertical axis if both axes are in one plot."""
DIRECTION_RGB: Final[dict[str, Rgb]] = {
    "right": (24, 118, 96),
    "left": (160, 60, 120),
    "up": (116, 104, 20),
    "down": (92, 86, 160),
}
"""Backgrounds of the direction lanes: dark enough for white text, and unlike ON and OFF."""
ARROW: Final = {"right": "→", "left": "←", "up": "↑", "down": "↓"}
COLORMAP: Final = "inferno"
"""Colour map of the fly's maps, in which 0 is black."""
NOISE_DIMMING: Final = 0.65
"""Brightness of noise events, relative to the colour of their polarity (by eye)."""
