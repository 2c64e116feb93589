"""The drawn scene: layers of log luminance, where each is at any time, and the truth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from scenarios.envelope.stimulus import Background, Stimulus, Surface
from scenarios.envelope.sway import Sway, make_sway
from scenarios.envelope.textures import crown, leaves, panels, saloon, street, stripes

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

LEAD_S = 0.2
"""How long the stream lasts before the crossing, or the middle of a longer one (assumed: a detector
with a memory of 100 ms has settled by then). The target enters at its end where the crossing is
drawn whole, earlier where its middle is, and is in view from the start where that takes longer than
WATCH_S + 2 LEAD_S: at the base point, sideways, below 245 px/s."""
WATCH_S = 1.5
"""Longest crossing that is drawn whole; of slower ones the middle is (assumed). At the base point
those are below 311 px/s sideways, and below 253 px/s up and down."""
STREET_CONTRAST = 0.3
"""Standard deviation of the background's log luminance (assumed; the simulated street by day has
0.85, most of which is sky against road)."""
SHAKE_RMS_PX, SHAKE_BAND_HZ = (1.5, 1.5), (1.0, 12.0)
"""A camera on a pole in the wind, or held in the hand: 0.25° (assumed)."""
WIND_RMS_PX, WIND_BAND_HZ = (2.0, 1.0), (0.5, 4.0)
"""Twigs in a breeze, mostly sideways: 5 cm at 8 m (assumed)."""
CROWNS, CROWN_PX, LEAF_CONTRAST = 8, (30, 60), 0.5
"""Trees at both sides of the way: how many, how wide [px], standard deviation of log luminance
(assumed)."""
FARTHER = 0.6
"""A distractor is a target in the far lane: this much as large, and as fast, in the image."""
LANE_GAP_PX = 12
"""Between target and distractor (assumed)."""
STRAY_PX = 20
"""The target's lane lies up to this far from the sensor's middle, by seed (assumed)."""
_AXIS = {Direction.RIGHT: 0, Direction.LEFT: 0, Direction.UP: 1, Direction.DOWN: 1}
_SIGN = {Direction.RIGHT: 1, Direction.LEFT: -1, Direction.UP: -1, Direction.DOWN: 1}


@dataclass(frozen=True, eq=False)
class Layer:
    """Something flat that moves as a whole.

    Attributes:
        paint: (rows, columns) float32, log luminance.
        cover: same shape, 1 where it hides what is behind it, 0 where it is see-through.
        middle_px: (x, y) of its middle at the time in the middle of the crossing [px].
        velocity_px_s: (x, y) [px/s].
        sway: what is added to that; None: nothing.
    """

    paint: F32
    cover: F32
    middle_px: tuple[float, float]
    velocity_px_s: tuple[float, float] = (0.0, 0.0)
    sway: Sway | None = None

    @property
    def size_px(self) -> F64:
        """(2,) width and height [px]."""
        return np.array(self.paint.shape[::-1], np.float64)

    def corner_px(self, t_s: F64) -> F64:
        """Upper left corner at times from the middle of the crossing, (n,) [s] to (n, 2) [px]."""
        start = np.array(self.middle_px) - self.size_px / 2
        corner: F64 = start + t_s[:, None] * np.array(self.velocity_px_s)
        return corner if self.sway is None else corner + self.sway.at(t_s)

    @property
    def fastest_px_s(self) -> float:
        """A speed that is never exceeded [px/s]."""
        return math.hypot(*self.velocity_px_s) + (self.sway.fastest_px_s if self.sway else 0.0)


@dataclass(frozen=True, eq=False)
class Scene:
    """Layers from back to front, before a street, seen by a camera that may shake.

    Attributes:
        stimulus: what was asked for.
        street: (height + 2·margin, width + 2·margin) float32, log luminance of the background.
        margin_px: how much of it lies outside the image on each side.
        layers: from back to front; the last is the target.
        shake: the whole image's displacement; None: the camera stands still.
    """

    stimulus: Stimulus
    street: F32
    margin_px: int
    layers: tuple[Layer, ...]
    shake: Sway | None

    @property
    def crossing_s(self) -> float:
        """How long the target is shown, but for the lead [s]."""
        return min(_crossing_s(self.stimulus), WATCH_S)

    @property
    def duration_us(self) -> int:
        """Length of the stream [µs]."""
        return round((LEAD_S + self.crossing_s) * 1e6)

    @property
    def fastest_px_s(self) -> float:
        """A speed that nothing in the image exceeds [px/s]."""
        shake = self.shake.fastest_px_s if self.shake else 0.0
        return shake + max(layer.fastest_px_s for layer in self.layers)

    def camera_px(self, t_us: F64) -> F64:
        """Displacement of the image at times from the start of the stream, (n,) to (n, 2) [px]."""
        if self.shake is None:
            return np.zeros((t_us.size, 2))
        return self.shake.at(t_us * 1e-6)

    def corners_px(self, t_us: F64) -> F64:
        """Upper left corners of the layers at times, (n,) [µs] to (n, layers, 2) [px]."""
        from_middle_s = t_us * 1e-6 - LEAD_S - self.crossing_s / 2
        corners = [layer.corner_px(from_middle_s) for layer in self.layers]
        return np.asarray(np.stack(corners, axis=1) + self.camera_px(t_us)[:, None], np.float64)

    def target_px(self, t_us: F64) -> F64:
        """The target's rectangle x0, y0, x1, y1, cut at the image's edge; (n,) to (n, 4) [px]."""
        s, corner = self.stimulus, self.corners_px(t_us)[:, -1]
        box = np.concatenate([corner, corner + self.layers[-1].size_px], axis=1)
        return np.asarray(np.clip(box, 0, (s.width, s.height, s.width, s.height)), np.float64)


def make_scene(stimulus: Stimulus) -> Scene:
    """Draw the textures and plan the motion of a stimulus; the same one gives the same scene."""
    rng = np.random.default_rng((stimulus.seed, 0))
    across_px = rng.uniform(-STRAY_PX, STRAY_PX)
    target = _vehicle(stimulus, 1.0, _place(stimulus, across_px), rng)
    moving: list[Layer] = []
    shake = None
    if stimulus.background is Background.WIND:
        moving = [_tree(stimulus, across_px, rng) for _ in range(CROWNS)]
    elif stimulus.background is Background.DISTRACTOR:
        moving = [_distractor(stimulus, across_px, rng)]
    elif stimulus.background is Background.SHAKE:
        shake = make_sway(SHAKE_RMS_PX, SHAKE_BAND_HZ, rng)
    margin = 2 + math.ceil(shake.farthest_px if shake else 0)
    shape = stimulus.height + 2 * margin, stimulus.width + 2 * margin
    ground = street(shape, contrast=STREET_CONTRAST, rng=rng)
    return Scene(stimulus, ground, margin, (*moving, target), shake)


def _crossing_s(s: Stimulus) -> float:
    """From the target's front coming into view to its rear leaving it [s]."""
    return ((s.width, s.height)[_AXIS[s.direction]] + s.length_px) / s.speed_px_s


def _place(s: Stimulus, across_px: float) -> tuple[float, float]:
    """(x, y) in the middle of the way, `across_px` beside the sensor's middle [px]."""
    x, y = s.width / 2, s.height / 2
    return (x, y + across_px) if _AXIS[s.direction] == 0 else (x + across_px, y)


def _vehicle(
    s: Stimulus, scale: float, middle_px: tuple[float, float], rng: np.random.Generator
) -> Layer:
    """A textured rectangle, `scale` as large and as fast as the target; backwards if negative."""
    shape = round(s.height_px * abs(scale)), round(s.length_px * abs(scale))
    paint, cover = _painted(s, shape, rng)
    axis, speed = _AXIS[s.direction], _SIGN[s.direction] * s.speed_px_s * scale
    if _SIGN[s.direction] < 0:
        paint, cover = paint[:, ::-1], cover[:, ::-1]
    if axis == 1:
        paint, cover = paint.T, cover.T
    velocity = (speed, 0.0) if axis == 0 else (0.0, speed)
    return Layer(paint, cover, middle_px, velocity)


def _painted(s: Stimulus, shape: tuple[int, int], rng: np.random.Generator) -> tuple[F32, F32]:
    """The target's log luminance and cover, its front to the right."""
    if s.surface is Surface.SALOON:
        return saloon(shape, contrast=s.contrast)
    if s.surface is Surface.PLAIN:
        paint = np.full(shape, s.contrast, np.float32)
    elif s.surface is Surface.STRIPES:
        paint = stripes(shape, contrast=s.contrast)
    else:
        paint = panels(shape, contrast=s.contrast, rng=rng)
    return paint, np.ones_like(paint)


def _distractor(s: Stimulus, across_px: float, rng: np.random.Generator) -> Layer:
    beside = (1 + FARTHER) / 2 * s.height_px + LANE_GAP_PX
    side = -1 if across_px > 0 else 1
    return _vehicle(s, -FARTHER, _place(s, across_px + side * beside), rng)


def _tree(s: Stimulus, across_px: float, rng: np.random.Generator) -> Layer:
    diameter = int(rng.integers(*CROWN_PX))
    beside = s.height_px / 2 + diameter / 2 + rng.uniform(0, 30)
    x, y = _place(s, across_px + rng.choice((-1, 1)) * beside)
    along = rng.uniform(-0.5, 0.5)
    middle = (x + along * s.width, y) if _AXIS[s.direction] == 0 else (x, y + along * s.height)
    shape = diameter, diameter
    paint = leaves(shape, contrast=LEAF_CONTRAST, rng=rng)
    sway = make_sway(WIND_RMS_PX, WIND_BAND_HZ, rng)
    return Layer(paint, crown(diameter, rng=rng), middle, sway=sway)
