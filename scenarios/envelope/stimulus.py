"""One drawn stimulus, fully specified: a textured target that crosses a textured background."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from flybench.checks import Range, check_ranges
from flybench.direction import CARDINAL, Direction
from scenarios.errors import ScenarioError


class Background(StrEnum):
    """What moves besides the target."""

    STILL = "still"
    SHAKE = "shake"
    WIND = "wind"
    DISTRACTOR = "distractor"


class Surface(StrEnum):
    """What the target is painted with."""

    PANELS = "panels"
    SALOON = "saloon"
    PLAIN = "plain"
    STRIPES = "stripes"


_RANGES = {
    "speed_px_s": Range(1.0, 20_000.0),
    "noise_hz": Range(0.0, 1_000.0),
    "contrast": Range(0.0, 3.0),
    "length_px": Range(4, 1_000),
    "seed": Range(0, 2**32 - 1),
    "width": Range(4, 4096),
    "height": Range(4, 4096),
}

_NAMED: dict[str, type[StrEnum]] = {
    "direction": Direction,
    "surface": Surface,
    "background": Background,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Stimulus:
    """What the drawn scene shows, and how noisy the pixels are.

    The defaults are the base point of the envelope, from which one factor at a time is changed.

    Attributes:
        speed_px_s: image speed of the target [px/s].
        noise_hz: Poisson events of either polarity, by pixel [Hz]. 1: between the published 0.1
            at 161 lux and 10 at 0.1 lux.
        contrast: standard deviation of the target's log luminance; of a plain one, its height over
            the street's. Assumed: 0.8, somewhat below the 1.05 measured over the pixels of the
            simulated car by day.
        direction: where the target goes in the image.
        length_px: the target's length along its way; it is two fifths of that high [px]. Assumed:
            120; the simulated car has 210 at the paper's distance.
        surface: panels of several sizes all over, a car with few edges, nothing but a rim, or
            stripes across the way.
        background: what else moves.
        seed: of texture, place, background, pixels and noise.
        width: sensor columns [px].
        height: sensor rows [px].

    Raises:
        ScenarioError: a value is outside its range or of another kind, or the direction is none.
    """

    speed_px_s: float = 350.0
    noise_hz: float = 1.0
    contrast: float = 0.8
    direction: Direction = Direction.RIGHT
    length_px: int = 120
    surface: Surface = Surface.PANELS
    background: Background = Background.STILL
    seed: int = 0
    width: int = 346
    height: int = 260

    @property
    def height_px(self) -> int:
        """The target's extent across its way [px]."""
        return max(2, round(0.4 * self.length_px))

    def __post_init__(self) -> None:
        check_ranges(self, _RANGES, ScenarioError)
        for name, names in _NAMED.items():
            value = getattr(self, name)
            if not isinstance(value, names):
                raise ScenarioError(
                    f"{name} of a drawn stimulus is {value!r}, a {type(value).__name__}; allowed "
                    f"is a {names.__module__}.{names.__name__}; write "
                    f"{names.__name__}.{next(iter(names)).name} or another of its members"
                )
        if self.direction not in CARDINAL:
            raise ScenarioError(
                f"the direction of a drawn stimulus is {self.direction.value!r}; allowed is right, "
                "left, up or down; a target that goes nowhere has no direction to be judged on"
            )
