"""The look of a house: walls, windows and doors, drawn at random.

Colours are linear reflectances. Colours, sizes and probabilities are assumed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Rgb = tuple[float, float, float]

WIDTH_M, STOREY_M = (5.6, 9.2), (2.65, 3.1)
"""Smallest and largest width of a house and height of a storey [m] (assumed)."""
LIT_SHARE = 0.35
"""Share of windows that are lit after dark (assumed)."""
LIT_CD_M2 = {"warm": 25.0, "bright": 60.0, "dim": 6.0}
"""Luminance of lit windows, with or without curtains [cd/m²] (assumed; a wall in a room at 150 lux
has about 25 cd/m²)."""
LIT_RGB = {"warm": (1.0, 0.72, 0.4), "bright": (1.0, 0.9, 0.75), "dim": (0.7, 0.8, 1.0)}
"""Linear colours of lit windows (by eye)."""
LIT_WINDOW = "mains_window_"
"""Prefix of the names of materials of lit windows."""
GLASS_RGB = (0.03, 0.035, 0.04)
"""Linear colour of a dark window pane (assumed)."""
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
"""Walls: texture, repeats per two metres, and linear colour (by eye)."""
DOORS = ((0.06, 0.16, 0.1), (0.25, 0.05, 0.04), (0.06, 0.08, 0.18), (0.12, 0.07, 0.04))
"""Linear colours of doors (by eye)."""
SIGNS = ((0.05, 0.12, 0.4), (0.4, 0.06, 0.05), (0.05, 0.25, 0.12))
"""Linear colours of shop signs (by eye)."""


@dataclass(frozen=True)
class Style:
    """Style that all windows of one house share.

    Attributes:
        half_width_m: half the width of a window frame [m].
        half_height_m: half the height of a window frame [m].
        pitch_m: distance from one window to the next [m].
        bars: number of upright bars in a window.
        crossed: True if windows have a horizontal bar.
        shutters: True if windows have shutters.
    """

    half_width_m: float
    half_height_m: float
    pitch_m: float
    bars: int
    crossed: bool
    shutters: bool


def draw_style(rng: np.random.Generator) -> Style:
    """Draw the window style of a house."""
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
    """Return one of some colours, a little lighter or darker, as (3,) float64."""
    chosen = np.array(colours[int(rng.integers(len(colours)))])
    return np.asarray(chosen * rng.uniform(0.8, 1.2))
