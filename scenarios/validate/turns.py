"""Mirror a window, and turn it by quarters: the same recording with other true directions.

A method that prefers a direction, by its parameters or because of the order in which the sensor is
read out, is right in some of these variants and wrong in others.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flybench.direction import Direction
from scenarios.validate.stimulus import Stimulus

_CLOCKWISE = {
    Direction.RIGHT: Direction.DOWN,
    Direction.DOWN: Direction.LEFT,
    Direction.LEFT: Direction.UP,
    Direction.UP: Direction.RIGHT,
    Direction.NONE: Direction.NONE,
}
_MIRRORED = {Direction.RIGHT: Direction.LEFT, Direction.LEFT: Direction.RIGHT}


@dataclass(frozen=True)
class Turn:
    """A variant of a window.

    Attributes:
        name: its name in tables.
        mirrored: True if left and right are exchanged.
        quarters: number of clockwise quarter turns after that.
    """

    name: str
    mirrored: bool = False
    quarters: int = 0

    def direction(self, direction: Direction) -> Direction:
        """Return the direction that a true direction becomes."""
        if self.mirrored:
            direction = _MIRRORED.get(direction, direction)
        for _ in range(self.quarters):
            direction = _CLOCKWISE[direction]
        return direction

    def stimulus(self, stimulus: Stimulus) -> Stimulus:
        """Return the stimulus that a stimulus becomes."""
        if self.mirrored:
            stimulus = _mirror(stimulus)
        for _ in range(self.quarters):
            stimulus = _turn_clockwise(stimulus)
        return stimulus


TURNS = (
    Turn("as it is"),
    Turn("mirrored", mirrored=True),
    Turn("turned by 90°", quarters=1),
    Turn("turned by 180°", quarters=2),
    Turn("turned by 270°", quarters=3),
)
"""All variants."""


def _mirror(stimulus: Stimulus) -> Stimulus:
    events = stimulus.events.copy()
    events["x"] = stimulus.width - 1 - events["x"]
    frames = tuple(
        replace(f, image=np.ascontiguousarray(f.image[:, ::-1])) for f in stimulus.frames
    )
    return replace(stimulus, events=events, frames=frames)


def _turn_clockwise(stimulus: Stimulus) -> Stimulus:
    events = stimulus.events.copy()
    events["x"] = stimulus.height - 1 - stimulus.events["y"]
    events["y"] = stimulus.events["x"]
    frames = tuple(
        replace(f, image=np.ascontiguousarray(np.rot90(f.image, k=-1))) for f in stimulus.frames
    )
    return replace(
        stimulus, events=events, frames=frames, width=stimulus.height, height=stimulus.width
    )
