"""Where things lie in a recording, and how they look."""

from __future__ import annotations

from typing import Final

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
TRUTH_CENTROID: Final = f"{TRUTH}/centroid"
FLY: Final = f"{CAMERA}/fly"
SURFACE_ON: Final = f"{FLY}/on"
SURFACE_OFF: Final = f"{FLY}/off"
MOTION: Final = tuple(f"{FLY}/motion/{name}" for name in ("right", "left", "up", "down"))
"""In the order of the planes of `FlyMaps.motion`."""
SALIENCY: Final = f"{FLY}/saliency"
ROI: Final = f"{FLY}/roi"
VIEW_CENTRE: Final = f"{FLY}/view_centre"

RESPONSE: Final = "response"
HS: Final = f"{RESPONSE}/hs"
VS: Final = f"{RESPONSE}/vs"
DIRECTION: Final = "direction"
TRUE_DIRECTION: Final = f"{DIRECTION}/truth"
FLY_DIRECTION: Final = f"{DIRECTION}/fly"
ANGULAR_VELOCITY: Final = "velocity/angular"
IMAGE_VELOCITY: Final = "velocity/image"
IMAGE_VELOCITY_X: Final = f"{IMAGE_VELOCITY}/x"
IMAGE_VELOCITY_Y: Final = f"{IMAGE_VELOCITY}/y"
RATE: Final = "event_rate"
RATE_ON: Final = f"{RATE}/on"
RATE_OFF: Final = f"{RATE}/off"
RATE_NOISE: Final = f"{RATE}/noise"

Rgb = tuple[int, int, int]

ON_RGB: Final[Rgb] = (255, 84, 72)
OFF_RGB: Final[Rgb] = (46, 214, 150)
"""The paper's red and green, of unequal lightness, so that the colour-blind tell them apart."""
NOISE_RGB: Final[Rgb] = (150, 150, 160)
TRUTH_RGB: Final[Rgb] = (255, 214, 64)
FLY_RGB: Final[Rgb] = (92, 190, 255)
VERTICAL_RGB: Final[Rgb] = (205, 140, 255)
DIRECTION_RGB: Final[dict[str, Rgb]] = {
    "right": (38, 110, 180),
    "left": (178, 100, 32),
    "up": (120, 80, 170),
    "down": (52, 130, 84),
}
"""Backgrounds of the direction lanes, dark enough for white letters."""
COLORMAP: Final = "inferno"
"""Of the fly's maps: black where nothing is."""
NOISE_DIMMING: Final = 0.55
"""An event that noise made has its polarity's colour, this much as bright (by eye)."""
