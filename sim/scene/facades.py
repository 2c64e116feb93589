"""Houses along the far side of the street, generated from a seed.

They are the two- and three-storey houses of a European town. Sizes are in metres. Sizes and
probabilities are assumed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np
import numpy.typing as npt

from sim.scene import lighting
from sim.scene.facade_style import (
    DOORS,
    GLASS_RGB,
    LIT_CD_M2,
    LIT_RGB,
    LIT_SHARE,
    LIT_WINDOW,
    SIGNS,
    STOREY_M,
    WALLS,
    WIDTH_M,
    Rgb,
    Style,
    draw_style,
    tint,
)

FRONT_M = 10.5
"""World y of the plane of the façades [m] (assumed)."""
PAVEMENT_M = 0.12
"""Height of the far pavement above the road, as in `street.xml` [m]."""
STREET_END_M = 27.0
"""Houses stand from −27 to +27 m along the road, so that even a lens of 100° sees no end of the row
(assumed)."""
_BOX = mujoco.mjtGeom.mjGEOM_BOX


class FacadeBuilder:
    """Builder of the houses of one street."""

    def __init__(self, spec: mujoco.MjSpec, seed: int, *, lit: bool) -> None:
        """Make a builder.

        Args:
            spec: model with the textures "brick" and "plaster" and the materials of `street.xml`.
            seed: seed of everything that is drawn at random.
            lit: True if windows are lit.
        """
        self._spec = spec
        self._rng = np.random.default_rng([seed, 0])
        self._lit = lit
        for name, luminance in LIT_CD_M2.items() if lit else ():
            self._lit_pane(name, luminance)

    def build(self) -> None:
        """Add all houses, from the left end of the street to the right."""
        walls = self._rng.permutation(len(WALLS))
        left, number = -STREET_END_M, 0
        while left < STREET_END_M:
            width = float(self._rng.uniform(*WIDTH_M))
            self._house(number, left, width, WALLS[walls[number % len(WALLS)]])
            left, number = left + width, number + 1

    def _lit_pane(self, name: str, luminance: float) -> None:
        """Add a material of dark glass that glows in one colour."""
        colour = LIT_RGB[name]
        texture = f"glow_{name}"
        self._spec.add_texture(
            name=texture,
            type=mujoco.mjtTexture.mjTEXTURE_2D,
            builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
            rgb1=colour,
            width=4,
            height=4,
            colorspace=mujoco.mjtColorSpace.mjCOLORSPACE_LINEAR,
        )
        material = _material(self._spec, LIT_WINDOW + name, GLASS_RGB)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_EMISSIVE] = texture
        lighting.set_luminance(material, luminance, colour)

    def _house(self, number: int, left: float, width: float, wall: tuple[str, float, Rgb]) -> None:
        rng = self._rng
        storeys, storey_m = int(rng.choice([2, 3, 3])), float(rng.uniform(*STOREY_M))
        height = 0.5 + storeys * storey_m
        material = self._wall(number, wall)
        middle, back = left + width / 2, float(rng.uniform(0, 0.004))
        # Walls of neighbours would share a plane, so each house is a little narrower than its plot.
        half = width / 2 - 0.004
        self._box([half, 2, height / 2], [middle, FRONT_M + 2 + back, height / 2], material)
        self._roof(middle, half, height)
        style = draw_style(rng)
        trim = "stone" if rng.uniform() < 0.5 else "white_paint"
        self._box([half - 0.01, 0.03, 0.22], [middle, FRONT_M - 0.01, 0.3], "stone", flat=True)
        for storey in range(1, storeys):
            sill = 0.35 + storey * storey_m + storey_m / 2
            self._row(left, width, sill, style, trim)
        if rng.uniform() < 0.4:
            self._shop(number, left, width, storey_m)
        else:
            self._ground_floor(left, width, storey_m, style, trim)

    def _wall(self, number: int, wall: tuple[str, float, Rgb]) -> str:
        texture, repeat, colour = wall
        name = f"wall_{number}"
        tint = np.clip(np.array(colour) * self._rng.normal(1, 0.07, 3), 0.05, 0.9)
        material = _material(self._spec, name, tint)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = texture
        material.texuniform = True
        material.texrepeat = [repeat * self._rng.uniform(0.93, 1.07)] * 2
        return name

    def _roof(self, middle: float, half: float, height: float) -> None:
        rng = self._rng
        trim = str(rng.choice(["slate", "stone"]))
        rise = float(rng.uniform(0.1, 0.18))
        out = float(rng.uniform(0.08, 0.2))
        self._box([half - 0.02, 2 + out, rise], [middle, FRONT_M + 2, height + rise - 0.02], trim)
        if rng.uniform() < 0.6:
            x = middle + float(rng.uniform(-0.7, 0.7)) * half
            self._box([0.35, 0.25, 0.6], [x, FRONT_M + 1.6, height + 0.7], "slate")

    def _row(self, left: float, width: float, z: float, style: Style, trim: str) -> None:
        count = max(int((width - 0.5) / style.pitch_m), 1)
        first = left + (width - (count - 1) * style.pitch_m) / 2
        for k in range(count):
            self._window(first + k * style.pitch_m, z, style, trim)

    def _window(self, x: float, z: float, style: Style, trim: str) -> None:
        w, h, y = style.half_width_m, style.half_height_m, FRONT_M - 0.03
        self._flat([w, 0.03, h], [x, y, z], trim)
        self._flat([w - 0.09, 0.03, h - 0.09], [x, y - 0.02, z], self._pane())
        for k in range(style.bars):
            across = (2 * (k + 1) / (style.bars + 1) - 1) * (w - 0.09)
            self._flat([0.028, 0.03, h - 0.087], [x + across, y - 0.035, z], trim)
        if style.crossed:
            self._flat([w - 0.086, 0.03, 0.025], [x, y - 0.033, z + 0.3 * h], trim)
        if (share := float(self._rng.uniform(-0.9, 0.8))) > 0:  # half of the windows have a blind
            drop = share * (h - 0.09)
            self._flat([w - 0.1, 0.03, drop], [x, y - 0.025, z + h - 0.088 - drop], "blind")
        if style.shutters:
            for side in (-1, 1):
                place = [x + side * (1.5 * w + 0.03), y + 0.004, z]
                self._flat([w / 2, 0.03, h - 0.006], place, "shutter")
        self._flat([w + 0.08, 0.1, 0.05], [x, y - 0.08, z - h - 0.05], "stone")

    def _pane(self) -> str:
        if self._rng.uniform() >= LIT_SHARE:
            self._rng.uniform()
            return "glass"
        names = list(LIT_CD_M2)
        name = names[int(self._rng.uniform() * len(names))]
        return LIT_WINDOW + name if self._lit else "glass"

    def _ground_floor(
        self, left: float, width: float, storey_m: float, style: Style, trim: str
    ) -> None:
        """Add a door at one end and windows beside it."""
        at_left = self._rng.uniform() < 0.5
        x = left + (1.0 if at_left else width - 1.0)
        self._door(x)
        rest = width - 2.0
        start = left + (2.0 if at_left else 0.0)
        self._row(start, rest, PAVEMENT_M + 0.25 + storey_m / 2, style, trim)

    def _door(self, x: float) -> None:
        z = PAVEMENT_M + 1.1
        self._flat([0.66, 0.04, 1.2], [x, FRONT_M - 0.02, z + 0.1], "stone")
        self._flat([0.5, 0.05, 1.08], [x, FRONT_M - 0.03, z], self._painted("door", DOORS))
        self._flat([0.36, 0.05, 0.14], [x, FRONT_M - 0.034, z + 0.85], self._pane())

    def _shop(self, number: int, left: float, width: float, storey_m: float) -> None:
        """Add a wide shop window with mullions, a sign, a door and sometimes an awning."""
        half, x = width / 2 - 1.1, left + width / 2 - 0.7
        y, z = FRONT_M - 0.03, PAVEMENT_M + 1.3
        self._flat([half, 0.04, 1.0], [x, y, z], self._pane())
        for edge in np.linspace(-half, half, int(3 + 2 * self._rng.uniform())):
            self._flat([0.045, 0.05, 1.03], [x + edge, y - 0.02, z + 0.01], "white_paint")
        self._flat([half + 0.01, 0.05, 0.25], [x, y - 0.012, PAVEMENT_M + 0.26], "slate")
        top = min(z + 1.28, PAVEMENT_M + storey_m)
        self._flat([half + 0.2, 0.05, 0.22], [x, y - 0.03, top], self._painted("sign", SIGNS))
        letters = half * float(self._rng.uniform(0.25, 0.5))
        for k, share in enumerate(self._rng.uniform(0.3, 1.0, 6)):
            across = letters * (2 * k / 5 - 1)
            size = [letters / 8, 0.02, 0.04 + 0.07 * share]
            self._flat(size, [x + across, y - 0.085, top], "white_paint")
        if self._rng.uniform() < 0.5:
            name = f"awning_{number}"
            _material(self._spec, name, tint(self._rng, ((0.5, 0.12, 0.1), (0.15, 0.3, 0.2))))
            size, place = [half + 0.1, 0.5, 0.03], [x, FRONT_M - 0.5, top - 0.32]
            self._box(size, place, name, slope_rad=0.24)
        self._door(left + width - 0.95)

    def _painted(self, kind: str, colours: Sequence[Rgb]) -> str:
        name = f"{kind}_{len(self._spec.materials)}"
        _material(self._spec, name, tint(self._rng, colours))
        return name

    def _flat(self, size: Sequence[float], place: Sequence[float], material: str) -> None:
        self._box(size, place, material, flat=True)

    def _box(
        self,
        size: Sequence[float],
        place: Sequence[float],
        material: str,
        *,
        flat: bool = False,
        slope_rad: float = 0.0,
    ) -> None:
        """Add a box with given half sizes, turned about the x axis. A flat box casts no shadow."""
        self._spec.worldbody.add_geom(
            type=_BOX,
            size=size,
            pos=place,
            material=material,
            castshadow=not flat,
            quat=[math.cos(slope_rad / 2), math.sin(slope_rad / 2), 0, 0],
        )


def _material(spec: mujoco.MjSpec, name: str, rgb: npt.ArrayLike) -> mujoco.MjsMaterial:
    colour = [*np.asarray(rgb, np.float64), 1.0]
    return spec.add_material(name=name, rgba=colour, metallic=0, roughness=0.95)
