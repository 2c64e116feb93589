"""Description of a synthetic stimulus: a textured target crosses a textured background."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from flybench.checks import Range, check_ranges
from flybench.direction import CARDINAL, Direction
from scenarios.errors import ScenarioError


class Background(StrEnum):
    """Motion besides that of the target."""

    STILL = "still"
    SHAKE = "shake"
    WIND = "wind"
    DISTRACTOR = "distractor"


class Surface(StrEnum):
    """Texture of the target."""

    PANELS = "panels"
    SALOON = "saloon"
    PLAIN = "plain"
    STRIPES = "stripes"
    BAR = "bar"
    BAND = "band"


BAR_PX = 6
"""Height of a bar [px] (assumed)."""

_RANGES = {
    "speed_px_s": Range(1.0, 20_000.0),
    "noise_hz": Range(0.0, 1_000.0),
    "contrast": Range(0.0, 3.0),
    "length_px": Range(4, 1_000),
    "tilt_deg": Range(
        -44.0, 44.0, "deg", remedy="At 45 deg, an edge across the path has no cardinal direction."
    ),
    "events_per_edge": Range(1, 50),
    "seed": Range(0, 2**32 - 1),
    "width": Range(4, 4096),
    "height": Range(4, 4096),
}

_ENUMERATIONS: dict[str, type[StrEnum]] = {
    "direction": Direction,
    "surface": Surface,
    "background": Background,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Stimulus:
    """Parameters of a synthetic stimulus and of the noise of the pixels.

    The defaults are the base point of the envelope, from which one factor at a time is changed.

    Attributes:
        speed_px_s: image speed of the target [px/s].
        noise_hz: rate of Poisson noise events per pixel, of either polarity [Hz]. The default of 1
            lies between the published 0.1 at 161 lux and 10 at 0.1 lux.
        contrast: standard deviation of the target's log luminance. For a plain target: its log
            luminance above the mean of the background. Assumed: 0.8, somewhat below the 1.05
            measured over the pixels of the simulated car by day.
        direction: direction of the target in the image.
        length_px: length of the target along its path [px]; its height is two fifths of that.
            Assumed: 120; the simulated car has 210 at the paper's distance.
        surface: texture of the target: panels of several sizes, a saloon car with few edges, plain
            (only the outline has edges), stripes across the path, a plain bar along the path, 6 px
            high, or a plain band across the path that is longer than the image, so that its ends
            are never in view.
        tilt_deg: rotation of the target about its centre, clockwise in the image [deg]. The true
            direction stays that of the motion. The motion of a band along itself cannot be seen,
            and the direction normal to its edges counts as right; below 45 deg, it is the same one
            of the four directions.
        events_per_edge: events of a pixel of the default sensor when an edge of 0.8 in log
            luminance passes. It scales the thresholds; with 2 they are those of the sensor.
        background: motion besides that of the target.
        seed: seed of texture, position, background, pixels and noise.
        width: sensor columns [px].
        height: sensor rows [px].

    Raises:
        ScenarioError: a value is out of range or has a wrong type, or the direction is none.
    """

    speed_px_s: float = 350.0
    noise_hz: float = 1.0
    contrast: float = 0.8
    direction: Direction = Direction.RIGHT
    length_px: int = 120
    surface: Surface = Surface.PANELS
    tilt_deg: float = 0.0
    events_per_edge: int = 2
    background: Background = Background.STILL
    seed: int = 0
    width: int = 346
    height: int = 260

    @property
    def height_px(self) -> int:
        """Extent of the target across its path, before it is tilted [px]."""
        if self.surface is Surface.BAR:
            return BAR_PX
        if self.surface is Surface.BAND:
            return 2 * math.ceil(math.hypot(self.width, self.height)) + 2 * self.length_px
        return max(2, round(0.4 * self.length_px))

    def __post_init__(self) -> None:
        check_ranges(self, _RANGES, ScenarioError)
        for name, names in _ENUMERATIONS.items():
            value = getattr(self, name)
            if not isinstance(value, names):
                raise ScenarioError(
                    f"{name} is {value!r}, a {type(value).__name__}. Allowed is a member of "
                    f"{names.__module__}.{names.__name__}. Write, for example, "
                    f"{names.__name__}.{next(iter(names)).name}."
                )
        if self.direction not in CARDINAL:
            raise ScenarioError(
                f"direction is {self.direction.value!r}. Allowed is right, left, up or down, "
                "because the target must move. Choose one of these directions."
            )
