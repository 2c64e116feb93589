"""Contrast maximisation: the image velocity under which the events of a window fit together best.

G. Gallego and D. Scaramuzza, "Accurate angular velocity estimation with an event camera", IEEE
Robotics and Automation Letters 2 (2), 2017; rewards after G. Gallego, M. Gehrig and D. Scaramuzza,
"Focus is all you need", CVPR 2019, and T. Stoffregen and L. Kleeman, "Event cameras, contrast
maximization and reward functions: an analysis", CVPR 2019, which the paper compares with.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from detector.contrast_maximisation.search import Candidate, search_cold, search_warm
from detector.contrast_maximisation.warped_events import Reward, WarpedEvents, centred_points
from detector.errors import DetectorConfigError
from detector.estimate import MotionEstimate
from detector.fly.tangential import winner_take_all, within_one
from detector.windowed import WindowedDetector, check_whole_hops
from flybench.checks import Range, check_ranges
from flybench.events import Events, empty_events, joined

__all__ = [
    "ContrastConfig",
    "ContrastEstimate",
    "ContrastMaximisation",
    "Reward",
    "maximise_contrast",
]

_GLANCE_EVENTS = 2500
"""With how many events a warm search looks all over (assumed): as many as a car's rims make."""
_SURVEY_EVENTS = 5000
"""With how many a cold search looks all over, before it follows the eight best with all (assumed):
on drawn dots of 120 to 1000 px/s all of them lead to the same velocities."""
_SHUFFLES = 16
"""How many times the events' times are exchanged to see what chance gives (assumed)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContrastConfig:
    """Parameters of contrast maximisation.

    None was chosen on the sequences that the methods are judged on.

    Attributes:
        reward: what the image of warped events is worth; see `Reward`. The gradient: on drawn
            windows of 120 to 1000 px/s its largest error was 1.8 px/s, the variance's 2.3.
        window_us: span of the events of one estimate [µs]. The event-driven fly's Δt.
        hop_us: step between estimates [µs]; windows are multiples of it. The fly's.
        limit_px_s: highest speed looked for [px/s]. 1500, the highest at which the fly was
            measured.
        most_events: of more events, so many are taken, evenly over the window. 20 000 (assumed):
            on drawn windows more did not change the velocity by 1 px/s.
        least_events: of fewer, no estimate is made (assumed).
        warm_start: whether an estimate starts from the one before, and looks everywhere only where
            that fails.
        prominence_floor: least prominence of a velocity that counts as motion; see
            `ContrastEstimate`. 8 (assumed):
            drawn noise of 0.1 to 20 Hz a pixel reaches 4, drawn targets far more.

    Raises:
        DetectorConfigError: a value of another type or outside its range.
    """

    reward: Reward = Reward.GRADIENT
    window_us: int = 50_000
    hop_us: int = 10_000
    limit_px_s: float = 1500.0
    most_events: int = 20_000
    least_events: int = 50
    warm_start: bool = True
    prominence_floor: float = 8.0

    def __post_init__(self) -> None:
        """Check every value, and bring it to its type."""
        check_ranges(self, _RANGES, DetectorConfigError)
        if not isinstance(self.reward, Reward):
            raise DetectorConfigError(
                f"reward is {self.reward!r}; allowed is one of "
                f"{', '.join(f'Reward.{r.name}' for r in Reward)}"
            )
        check_whole_hops(self.hop_us, window_us=self.window_us)


_RANGES: dict[str, Range] = {
    "window_us": Range(1000, 10_000_000),
    "hop_us": Range(1000, 10_000_000),
    "limit_px_s": Range(1.0, 100_000.0),
    "most_events": Range(10, 10_000_000),
    "least_events": Range(2, 10_000_000),
    "prominence_floor": Range(0.0, 1e6),
}


@dataclass(frozen=True, slots=True)
class ContrastEstimate:
    """The velocity of highest reward in one window of events.

    Attributes:
        velocity_px_s: (x, y) [px/s].
        reward: of that velocity, with image pixels of 1 px.
        prominence: how far the reward stands out from those of the same velocity when the events
            have exchanged their times, in standard deviations. What moves loses its edges by
            that; noise does not, nor does what flickers in its place.
        is_cold: whether all velocities were looked at.
    """

    velocity_px_s: tuple[float, float]
    reward: float
    prominence: float
    is_cold: bool


def maximise_contrast(
    events: Events,
    *,
    from_us: int,
    to_us: int,
    width: int,
    height: int,
    config: ContrastConfig | None = None,
    start: Candidate | None = None,
) -> ContrastEstimate | None:
    """Find the one velocity that explains most of a window's events.

    Args:
        events: of the window, sorted by t.
        from_us: start of the window [µs].
        to_us: end of the window, exclusive [µs].
        width: sensor columns [px].
        height: sensor rows [px].
        config: reward and search; the defaults where None. Its windows and hops are not used.
        start: velocity to start from [px/s]; None: look everywhere.

    Returns:
        The estimate, or None where there are too few events.
    """
    c = config or ContrastConfig()
    if events.size < c.least_events:
        return None
    window_s = (to_us - from_us) * 1e-6
    reach = c.limit_px_s * window_s
    area_px = (width + reach) * (height + reach)

    def at_most(number: int) -> WarpedEvents:
        points = centred_points(events, most=number, middle_us=(from_us + to_us) / 2)
        return WarpedEvents(points, reward=c.reward, area_px=area_px)

    warped = at_most(c.most_events)
    limits = {"window_s": window_s, "limit_px_s": c.limit_px_s}
    if start is not None:
        glance = at_most(_GLANCE_EVENTS)
        velocity = search_warm(warped.rewards, glance.rewards, start, **limits)
        found = _told(warped, velocity, is_cold=False)
        if found.prominence >= c.prominence_floor and math.hypot(*velocity) <= c.limit_px_s:
            return found
    survey = at_most(_SURVEY_EVENTS)
    velocity = search_cold(warped.rewards, survey_at=survey.rewards, **limits)
    return _told(warped, velocity, is_cold=True)


def _told(warped: WarpedEvents, velocity: Candidate, *, is_cold: bool) -> ContrastEstimate:
    """A velocity with its reward, and how far that is from chance."""
    reward = float(warped.rewards(np.array([velocity]), 1.0)[0])
    by_chance = warped.rewards_by_chance(velocity, 1.0, _orders(warped.number))
    return ContrastEstimate(velocity, reward, _standard_score(reward, by_chance), is_cold)


@lru_cache(maxsize=2)
def _orders(number: int) -> npt.NDArray[np.int32]:
    """(shuffles, number) random orders, the same for as many events; most windows have as many."""
    rng = np.random.default_rng(0)
    return np.stack([rng.permutation(number) for _ in range(_SHUFFLES)]).astype(np.int32)


def _standard_score(value: float, others: npt.NDArray[np.float64]) -> float:
    spread = float(np.std(others, ddof=1))
    return (value - float(np.mean(others))) / spread if spread > 0.0 else 0.0


class ContrastMaximisation(WindowedDetector):
    """Contrast maximisation as a `Detector`: a window of events at every hop.

    Its response is the velocity itself [px/s]; hs and vs are its shares of the highest speed
    looked for. It attends nowhere: its view centre is the image's.
    """

    def __init__(
        self, config: ContrastConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 with an empty window.

        Args:
            config: parameters; the defaults where None.
            width: sensor columns [px].
            height: sensor rows [px].
        """
        self.config = c = config or ContrastConfig()
        super().__init__(c.hop_us, width=width, height=height)
        hops = c.window_us // c.hop_us
        self._window = deque([empty_events()] * hops, maxlen=hops)
        self._before: Candidate | None = None

    def _estimate(self, end_us: int, events: Events) -> MotionEstimate:
        c = self.config
        self._window.append(events)
        found = maximise_contrast(
            joined(self._window),
            from_us=end_us - c.window_us,
            to_us=end_us,
            width=self._width,
            height=self._height,
            config=c,
            start=self._before,
        )
        if found is None or found.prominence < c.prominence_floor:
            self._before = None
        elif c.warm_start:
            self._before = found.velocity_px_s
        return self._told(end_us, found)

    def _told(self, end_us: int, found: ContrastEstimate | None) -> MotionEstimate:
        """The velocity as every detector says it."""
        c = self.config
        velocity, prominence = (
            (found.velocity_px_s, found.prominence) if found is not None else ((0.0, 0.0), 0.0)
        )
        hs, vs = (within_one(v / c.limit_px_s) for v in velocity)
        snr, floor = (prominence, prominence), c.prominence_floor
        return MotionEstimate(
            t_us=end_us,
            hs=hs,
            vs=vs,
            direction=winner_take_all(hs, vs, snr=snr, snr_floor=floor),
            strength=max(abs(hs), abs(vs)),
            response=velocity,
            view_centre_px=(self._width / 2, self._height / 2),
            roi_px=None,
        )
