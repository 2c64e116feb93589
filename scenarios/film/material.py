"""What a film shows: a stream of events and frames, the estimates of one method, and the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy.typing as npt

from flybench.events import Events
from scenarios.film.track import Track

Box = tuple[int, int, int, int]
"""x0, y0, x1, y1, half-open [px]."""
Picture = tuple[int, npt.NDArray[Any]]
"""An APS frame: the end of its exposure [µs], and its image of (height, width) grey levels."""
Part = tuple[Events, tuple[Picture, ...]]
"""Next events and APS frames of a stream, each in order of time."""


@dataclass(frozen=True, eq=False)
class Estimates:
    """Estimates of one method over time.

    Attributes:
        method: name of the method; None: there are no estimates.
        hs: horizontal response, rightward > 0.
        vs: vertical response, downward > 0.
        direction: name of the direction; "" for none.
        region: region of interest; None for none.
    """

    method: str | None = None
    hs: Track[float] = field(default_factory=Track)
    vs: Track[float] = field(default_factory=Track)
    direction: Track[str] = field(default_factory=Track)
    region: Track[Box | None] = field(default_factory=Track)


@dataclass(frozen=True, eq=False)
class Truth:
    """True direction and box of the target over time; "" and None while it is out of view."""

    direction: Track[str]
    box: Track[Box | None]


@dataclass(frozen=True, eq=False)
class Material:
    """What a film shows of one recording.

    Attributes:
        name: title.
        width: sensor columns [px].
        height: sensor rows [px].
        from_us: time of the first event or frame [µs].
        to_us: time of the last one [µs].
        estimates: estimates of the method that is shown.
        truth: ground truth; None if it is unknown.
        read: function that reads the stream from its start.
    """

    name: str
    width: int
    height: int
    from_us: int
    to_us: int
    estimates: Estimates
    truth: Truth | None
    read: Callable[[], Iterator[Part]]
