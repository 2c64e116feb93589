"""How a house looks: walls, windows and doors, each drawn at random from what streets have.

Colours are linear reflectances; they, the sizes and the chances are assumed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Rgb = tuple[float, float, float]

WIDTH_M, STOREY_M = (5.6, 9.2), (2.65, 3.1)
"""Of a house and of its storeys, least and most (assumed)."""
LIT_SHARE = 0.35
"""Part of the windows that are lit after dark (assumed)."""
LIT_CD_M2 = {"warm": 25.0, "bright": 60.0, "dim": 6.0}
"""Luminance of lit windows, seen through curtains or not (assumed; a wall in a room lit to 150 lux
has some 25 cd/m²)."""
LIT_RGB = {"warm": (1.0, 0.72, 0.4), "bright": (1.0, 0.9, 0.75), "dim": (0.7, 0.8, 1.0)}
"""Linear colours of their light (by eye)."""
LIT_WINDOW = "mains_window_"
"""How the names of lit windows' materials begin."""
GLASS_RGB = (0.03, 0.035, 0.04)
"""Linear colour of a dark window: what little a pane gives back (assumed)."""
WALLS = (
    ("plaster", 0.4, (0.45, 0.47, 0.5)),
    ("brick", 0.6, (0.42, 0.2, 0.14)),
    ("plaster", 0.4, (0.72, 0.64, 0.48)),
    ("brick", 0.6, (0.6, 0.47, 0.28)),
    ("plaster", 0.4, (0.62, 0.42, 0.33)),
    ("brick", 0.6, (0.3, 0.17, 0.13)),
    ("plaster", 0.4, (0.5, 0.56, 0.46)),
    ("plaster", 0.4, (0.8, 0.79, 0.75)),
)
"""Texture, its repeats per two metres, and linear colour (by eye)."""
DOORS = ((0.06, 0.16, 0.1), (0.25, 0.05, 0.04), (0.06, 0.08, 0.18), (0.12, 0.07, 0.04))
"""Linear colours of doors (by eye)."""
SIGNS = ((0.05, 0.12, 0.4), (0.4, 0.06, 0.05), (0.05, 0.25, 0.12))
"""Linear colours of shop signs (by eye)."""


@dataclass(frozen=True)
class Style:
    """What the windows of one house have in common.

    Attributes:
        half_width_m: of a window's frame.
        half_height_m: likewise.
        pitch_m: from one to the next.
        bars: how many upright bars divide it.
        crossed: whether a level one does.
        shutters: whether it has shutters.
    """

    half_width_m: float
    half_height_m: float
    pitch_m: float
    bars: int
    crossed: bool
    shutters: bool


def draw_style(rng: np.random.Generator) -> Style:
    """The windows of a house."""
    half_width = float(rng.uniform(0.45, 0.72))
    shutters = bool(rng.uniform() < 0.3)
    return Style(
        half_width_m=half_width,
        half_height_m=float(rng.uniform(0.65, 0.9)),
        pitch_m=half_width * (4.4 if shutters else 2.4) + float(rng.uniform(0.4, 1.0)),
        bars=int(rng.integers(0, 3)),
        crossed=bool(rng.uniform() < 0.5),
        shutters=shutters,
    )


def tint(rng: np.random.Generator, colours: Sequence[Rgb]) -> npt.NDArray[np.float64]:
    """(3,) one of some colours, a little lighter or darker."""
    chosen = np.array(colours[int(rng.integers(len(colours)))])
    return np.asarray(chosen * rng.uniform(0.8, 1.2))
