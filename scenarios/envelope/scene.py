"""The scene of a synthetic stimulus: layers of log luminance, their motion, and the truth."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from scenarios.envelope.oscillation import Oscillation, random_oscillation
from scenarios.envelope.stimulus import Background, Stimulus, Surface
from scenarios.envelope.textures import (
    foliage,
    panels,
    rotated,
    saloon_car,
    smooth_background,
    stripes,
    tree_crown,
)

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

LEAD_S = 0.2
"""Duration of the stream before the crossing, or before the part of it that is generated (assumed:
a detector with a memory of 100 ms has settled by then). If the whole crossing is drawn, the target
enters the image at the end of the lead; otherwise it enters earlier. It is in view from the start
if the crossing takes longer than MAX_CROSSING_S + 2 LEAD_S: at the base point, for horizontal
motion below 245 px/s."""
MAX_CROSSING_S = 1.5
"""Longest crossing that is drawn completely; of slower ones only the middle is drawn (assumed). At
the base point these are below 311 px/s for horizontal and 253 px/s for vertical motion."""
BACKGROUND_CONTRAST = 0.3
"""Standard deviation of the background's log luminance (assumed; the simulated street by day has
0.85, mostly from the contrast of sky and road)."""
SHAKE_RMS_PX, SHAKE_BAND_HZ = (1.5, 1.5), (1.0, 12.0)
"""Shake of a camera on a pole in the wind, or of a hand-held one: 0.25° (assumed)."""
WIND_RMS_PX, WIND_BAND_HZ = (2.0, 1.0), (0.5, 4.0)
"""Motion of twigs in a breeze, mostly sideways: 5 cm at a distance of 8 m (assumed)."""
TREES, TREE_DIAMETER_PX, FOLIAGE_CONTRAST = 8, (30, 60), 0.5
"""Trees on both sides of the path: number, range of diameters [px], and standard deviation of log
luminance (assumed)."""
DISTRACTOR_SCALE = 0.6
"""Size and speed of the distractor, which drives in the far lane, relative to the target."""
LANE_GAP_PX = 12
"""Gap between target and distractor (assumed)."""
LANE_OFFSET_PX = 20
"""Greatest offset of the target's lane from the centre of the sensor; it depends on the seed
(assumed)."""
_AXIS = {Direction.RIGHT: 0, Direction.LEFT: 0, Direction.UP: 1, Direction.DOWN: 1}
_SIGN = {Direction.RIGHT: 1, Direction.LEFT: -1, Direction.UP: -1, Direction.DOWN: 1}


@dataclass(frozen=True, eq=False)
class Layer:
    """A flat object that moves as a whole.

    Attributes:
        texture: (rows, columns) float32, log luminance.
        opacity: (rows, columns) float32, 1 where it hides what is behind it, 0 where transparent.
        centre_px: (x, y) of its centre, half way through the crossing [px].
        velocity_px_s: (x, y) velocity [px/s].
        oscillation: motion that is added to the velocity; None: none.
        outline_px: (4, 2) corners of a tilted object, from the upper left corner of its texture
            [px]; None: the object fills its texture.
    """

    texture: F32
    opacity: F32
    centre_px: tuple[float, float]
    velocity_px_s: tuple[float, float] = (0.0, 0.0)
    oscillation: Oscillation | None = None
    outline_px: F64 | None = None

    @property
    def size_px(self) -> F64:
        """(2,) width and height [px]."""
        return np.array(self.texture.shape[::-1], np.float64)

    def corner_px(self, t_s: F64) -> F64:
        """Return the upper left corner (n, 2) [px] at times (n,) from half way through [s]."""
        start = np.array(self.centre_px) - self.size_px / 2
        corner: F64 = start + t_s[:, None] * np.array(self.velocity_px_s)
        return corner if self.oscillation is None else corner + self.oscillation.at(t_s)

    @property
    def max_speed_px_s(self) -> float:
        """Upper bound of the speed [px/s]."""
        oscillation = self.oscillation.max_speed_px_s if self.oscillation else 0.0
        return math.hypot(*self.velocity_px_s) + oscillation


@dataclass(frozen=True, eq=False)
class Scene:
    """Layers in front of a background, seen by a camera that may shake.

    Attributes:
        stimulus: description of the stimulus.
        background: (height + 2·margin, width + 2·margin) float32, log luminance.
        margin_px: how far the background extends beyond the image on each side.
        layers: layers from back to front; the last one is the target.
        shake: displacement of the whole image; None: the camera does not move.
    """

    stimulus: Stimulus
    background: F32
    margin_px: int
    layers: tuple[Layer, ...]
    shake: Oscillation | None

    @property
    def crossing_s(self) -> float:
        """Duration of the stream without the lead [s]."""
        return min(_crossing_s(self.stimulus), MAX_CROSSING_S)

    @property
    def duration_us(self) -> int:
        """Duration of the stream [µs]."""
        return round((LEAD_S + self.crossing_s) * 1e6)

    @property
    def max_speed_px_s(self) -> float:
        """Upper bound of all speeds in the image [px/s]."""
        shake = self.shake.max_speed_px_s if self.shake else 0.0
        return shake + max(layer.max_speed_px_s for layer in self.layers)

    def image_shift_px(self, t_us: F64) -> F64:
        """Return the displacement of the image (n, 2) [px] at times (n,) in the stream [µs]."""
        if self.shake is None:
            return np.zeros((t_us.size, 2))
        return self.shake.at(t_us * 1e-6)

    def corners_px(self, t_us: F64) -> F64:
        """Return the upper left corners of the layers (n, layers, 2) [px] at times (n,) [µs]."""
        t_s = t_us * 1e-6 - LEAD_S - self.crossing_s / 2
        corners = np.stack([layer.corner_px(t_s) for layer in self.layers], axis=1)
        return np.asarray(corners + self.image_shift_px(t_us)[:, None], np.float64)

    def target_px(self, t_us: F64) -> F64:
        """Return the target's clipped x0, y0, x1, y1 (n, 4) [px] at times (n,) [µs]."""
        s, corner, target = self.stimulus, self.corners_px(t_us)[:, -1], self.layers[-1]
        if target.outline_px is not None:
            outlines = (target.outline_px + c for c in corner)
            return np.array([visible_box(o, width=s.width, height=s.height) for o in outlines])
        box = np.concatenate([corner, corner + target.size_px], axis=1)
        return np.asarray(np.clip(box, 0, (s.width, s.height, s.width, s.height)), np.float64)


def make_scene(stimulus: Stimulus) -> Scene:
    """Draw the textures and plan the motion of a stimulus; equal stimuli give equal scenes."""
    rng = np.random.default_rng((stimulus.seed, 0))
    across_px = rng.uniform(-LANE_OFFSET_PX, LANE_OFFSET_PX)
    target = _tilted(_vehicle(stimulus, 1.0, _centre_px(stimulus, across_px), rng), stimulus)
    moving: list[Layer] = []
    shake = None
    if stimulus.background is Background.WIND:
        moving = [_tree(stimulus, across_px, rng) for _ in range(TREES)]
    elif stimulus.background is Background.DISTRACTOR:
        moving = [_distractor(stimulus, across_px, rng)]
    elif stimulus.background is Background.SHAKE:
        shake = random_oscillation(SHAKE_RMS_PX, SHAKE_BAND_HZ, rng)
    margin = 2 + math.ceil(shake.max_displacement_px if shake else 0)
    shape = stimulus.height + 2 * margin, stimulus.width + 2 * margin
    background = smooth_background(shape, contrast=BACKGROUND_CONTRAST, rng=rng)
    return Scene(stimulus, background, margin, (*moving, target), shake)


def _crossing_s(s: Stimulus) -> float:
    """Return the time from the target's front entering the image to its rear leaving it [s]."""
    return ((s.width, s.height)[_AXIS[s.direction]] + s.length_px) / s.speed_px_s


def _centre_px(s: Stimulus, across_px: float) -> tuple[float, float]:
    """Return the centre of the sensor, moved by `across_px` across the path [px]."""
    x, y = s.width / 2, s.height / 2
    return (x, y + across_px) if _AXIS[s.direction] == 0 else (x + across_px, y)


def _vehicle(
    s: Stimulus, scale: float, centre_px: tuple[float, float], rng: np.random.Generator
) -> Layer:
    """Return a vehicle with size and speed scaled; with a negative scale it moves backwards."""
    shape = round(s.height_px * abs(scale)), round(s.length_px * abs(scale))
    texture, opacity = _appearance(s, shape, rng)
    axis, speed = _AXIS[s.direction], _SIGN[s.direction] * s.speed_px_s * scale
    if _SIGN[s.direction] < 0:
        texture, opacity = texture[:, ::-1], opacity[:, ::-1]
    if axis == 1:
        texture, opacity = texture.T, opacity.T
    velocity = (speed, 0.0) if axis == 0 else (0.0, speed)
    return Layer(texture, opacity, centre_px, velocity)


def _tilted(target: Layer, s: Stimulus) -> Layer:
    """Return the target, rotated about its centre; its motion stays as it is."""
    if s.tilt_deg == 0.0:
        return target
    texture, opacity = rotated(target.texture, target.opacity, s.tilt_deg)
    (w, h), centre = target.size_px / 2, np.array(texture.shape[::-1]) / 2
    corners = np.array([(-w, -h), (w, -h), (w, h), (-w, h)])
    sine, cosine = math.sin(math.radians(s.tilt_deg)), math.cos(math.radians(s.tilt_deg))
    outline = centre + corners @ np.array([(cosine, sine), (-sine, cosine)])
    return replace(target, texture=texture, opacity=opacity, outline_px=outline)


def visible_box(outline_px: F64, *, width: int, height: int) -> tuple[float, float, float, float]:
    """Return the bounding box of the part of a convex outline (n, 2) that is in the image [px].

    Returns:
        x0, y0, x1, y1; zeros if no part is in the image.
    """
    image = np.array([(0, 0), (width, 0), (width, height), (0, height)], np.float32)
    area, part = cv2.intersectConvexConvex(outline_px.astype(np.float32), image)
    if area <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    points = part.reshape(-1, 2)
    (x0, y0), (x1, y1) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return x0, y0, x1, y1


def _appearance(s: Stimulus, shape: tuple[int, int], rng: np.random.Generator) -> tuple[F32, F32]:
    """Return texture and opacity of a vehicle that faces right."""
    if s.surface is Surface.SALOON:
        return saloon_car(shape, contrast=s.contrast)
    if s.surface in (Surface.PLAIN, Surface.BAR, Surface.BAND):
        texture = np.full(shape, s.contrast, np.float32)
    elif s.surface is Surface.STRIPES:
        texture = stripes(shape, contrast=s.contrast)
    else:
        texture = panels(shape, contrast=s.contrast, rng=rng)
    return texture, np.ones_like(texture)


def _distractor(s: Stimulus, across_px: float, rng: np.random.Generator) -> Layer:
    beside = (1 + DISTRACTOR_SCALE) / 2 * s.height_px + LANE_GAP_PX
    side = -1 if across_px > 0 else 1
    return _vehicle(s, -DISTRACTOR_SCALE, _centre_px(s, across_px + side * beside), rng)


def _tree(s: Stimulus, across_px: float, rng: np.random.Generator) -> Layer:
    diameter = int(rng.integers(*TREE_DIAMETER_PX))
    beside = s.height_px / 2 + diameter / 2 + rng.uniform(0, 30)
    x, y = _centre_px(s, across_px + rng.choice((-1, 1)) * beside)
    along = rng.uniform(-0.5, 0.5)
    centre = (x + along * s.width, y) if _AXIS[s.direction] == 0 else (x, y + along * s.height)
    shape = diameter, diameter
    texture = foliage(shape, contrast=FOLIAGE_CONTRAST, rng=rng)
    wind = random_oscillation(WIND_RMS_PX, WIND_BAND_HZ, rng)
    return Layer(texture, tree_crown(diameter, rng=rng), centre, oscillation=wind)
