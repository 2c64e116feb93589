"""Where things lie in a recording, and how they look."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import rerun as rr

TIMELINE: Final = "time"
"""The one time line: time since the start of the sequence."""

WORLD: Final = "world"
STREET: Final = f"{WORLD}/street"
CAMERA: Final = f"{WORLD}/camera"
"""A pinhole; all below it is in image coordinates, sensor pixels, (0, 0) the outer corner."""
PREVIEW: Final = f"{CAMERA}/preview"
APS: Final = f"{CAMERA}/aps"
EVENTS: Final = f"{CAMERA}/events"
TRUTH: Final = f"{CAMERA}/truth"
TRUTH_MASK: Final = f"{TRUTH}/mask"
TRUTH_BOX: Final = f"{TRUTH}/box"
PREVIEW_BOX: Final = f"{TRUTH}/preview_box"
PREVIEW_CENTROID: Final = f"{TRUTH}/preview_centroid"
"""Mask, box and centroid at the moments of the preview, which comes less often than the truth."""
METHODS: Final = f"{CAMERA}/methods"
"""What each method attends to and sees, by its name; see `paths_of`."""

DIRECTION: Final = "direction"
TRUE_DIRECTION: Final = f"{DIRECTION}/0_truth"
"""The viewer sorts lanes by their paths, so they are numbered: the truth first."""
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
    """Where one method's words and maps lie.

    Attributes:
        direction: what it decides; a lane.
        hs, vs: its normalised responses; curves.
        velocity_x, velocity_y: its image velocity [px/s], of a method that gives one; curves.
        roi, view_centre: what it attends to, in the image.
        on, off, motion, saliency: a fly's maps; `motion` in the order of `FlyMaps.motion`.
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
    """Paths of the method of a name, the `number`-th of a recording, counted from 0."""
    part = rr.escape_entity_path_part(method)
    seen = f"{METHODS}/{part}"
    return MethodPaths(
        direction=f"{DIRECTION}/{number + 1}_{part}",
        hs=f"{HS}/{part}",
        vs=f"{VS}/{part}",
        velocity_x=f"{IMAGE_VELOCITY_X}/{part}",
        velocity_y=f"{IMAGE_VELOCITY_Y}/{part}",
        roi=f"{seen}/roi",
        view_centre=f"{seen}/view_centre",
        on=f"{seen}/on",
        off=f"{seen}/off",
        motion=tuple(f"{seen}/motion/{name}" for name in ("right", "left", "up", "down")),
        saliency=f"{seen}/saliency",
    )


Rgb = tuple[int, int, int]

ON_RGB: Final[Rgb] = (255, 84, 72)
OFF_RGB: Final[Rgb] = (46, 214, 150)
"""The paper's red and green, of unequal lightness, so that the colour-blind tell them apart."""
NOISE_RGB: Final[Rgb] = (150, 150, 160)
TRUTH_RGB: Final[Rgb] = (255, 214, 64)
METHOD_RGB: Final[tuple[Rgb, ...]] = (
    (92, 190, 255),
    (255, 150, 60),
    (205, 140, 255),
    (240, 240, 240),
    (255, 120, 190),
    (170, 200, 90),
)
"""Of the methods of a recording, in turn: told apart from the truth, ON and OFF (by eye)."""
VERTICAL_RGB: Final[Rgb] = (205, 140, 255)
"""Of the vertical axis, where both are in one plot."""
DIRECTION_RGB: Final[dict[str, Rgb]] = {
    "right": (38, 110, 180),
    "left": (178, 100, 32),
    "up": (120, 80, 170),
    "down": (52, 130, 84),
}
"""Backgrounds of the direction lanes, dark enough for white letters."""
ARROW: Final = {"right": "→", "left": "←", "up": "↑", "down": "↓"}
COLORMAP: Final = "inferno"
"""Of the fly's maps: black where nothing is."""
NOISE_DIMMING: Final = 0.55
"""An event that noise made has its polarity's colour, this much as bright (by eye)."""
