"""Contrast maximisation: the image velocity for which the image of warped events is sharpest.

G. Gallego and D. Scaramuzza, "Accurate angular velocity estimation with an event camera", IEEE
Robotics and Automation Letters 2 (2), 2017. Rewards after G. Gallego, M. Gehrig and D. Scaramuzza,
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

from detector.contrast_maximisation.search import Velocity, search_cold, search_warm
from detector.contrast_maximisation.warped_events import Reward, WarpedEvents, centred_points
from detector.decision import velocity_estimate
from detector.errors import DetectorConfigError
from detector.estimate import MotionEstimate
from detector.windowed import WindowedDetector, check_whole_hops
from flybench.checks import Range, check_ranges
from flybench.events import Events, concatenate_events, empty_events
from flybench.memory import count_memory

__all__ = [
    "ContrastConfig",
    "ContrastEstimate",
    "ContrastMaximisation",
    "Reward",
    "maximise_contrast",
]

_WARM_SCAN_EVENTS = 2500
"""Number of events with which a warm search scans all velocities: about the number that the edges
of a car cause in a window (assumed)."""
_COLD_SCAN_EVENTS = 5000
"""Events with which a cold search scans all velocities before it follows the eight best with all
events (assumed). On synthetic dots of 120 to 1000 px/s this number leads to the same velocities as
all events."""
_SHUFFLES = 16
"""Number of random exchanges of the bursts' times, to estimate the reward by chance (assumed)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContrastConfig:
    """Parameters of contrast maximisation.

    No value was chosen on the sequences that detectors are evaluated on.

    Attributes:
        reward: measure of the sharpness of the image of warped events; see `Reward`. The default is
            the gradient: on synthetic windows of 120 to 1000 px/s its largest error was 1.8 px/s,
            and that of the variance 2.3 px/s.
        window_us: span of the events of one estimate [µs]. The default is Δt of the event-driven
            fly.
        hop_us: step between estimates [µs]; the window is a multiple of it. The default is the step
            of the event-driven fly.
        limit_px_s: highest speed that is searched [px/s]. 1500, the highest at which the fly was
            measured.
        most_events: largest number of events used; from more events, this many are taken, evenly
            over the window. 20 000: on synthetic windows more events did not change the velocity by
            1 px/s (assumed).
        least_events: least number of events for an estimate (assumed).
        warm_start: True: start from the previous velocity, and search all velocities only if that
            fails.
        prominence_floor: least prominence of a velocity that counts as motion; see
            `ContrastEstimate`. 8: synthetic noise of 0.1 to 20 Hz per pixel reaches 4, synthetic
            targets far more (assumed).

    Raises:
        DetectorConfigError: a value has the wrong type or is out of range.
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
        """Check every value and convert it to its type."""
        check_ranges(self, _RANGES, DetectorConfigError)
        if not isinstance(self.reward, Reward):
            raise DetectorConfigError(
                f"reward is {self.reward!r}. Allowed is one of "
                f"{', '.join(f'Reward.{r.name}' for r in Reward)}."
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
        reward: reward of that velocity, with image pixels of 1 px.
        prominence: how far this reward exceeds the rewards of the same velocity after the bursts of
            all pixels have exchanged their times, in standard deviations. The exchange destroys the
            edges of a moving object, but changes neither noise nor flicker in place.
        is_cold: True if all velocities were searched.
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
    start: Velocity | None = None,
) -> ContrastEstimate | None:
    """Find the one velocity that explains most events of a window.

    Args:
        events: events of the window, sorted by t.
        from_us: start of the window [µs].
        to_us: end of the window, exclusive [µs].
        width: sensor columns [px].
        height: sensor rows [px].
        config: reward and search; None: the defaults. Its window and hop are not used.
        start: velocity to start from [px/s]; None: search all velocities.

    Returns:
        The estimate, or None if there are too few events.
    """
    c = config or ContrastConfig()
    if events.size < c.least_events:
        return None
    window_s = (to_us - from_us) * 1e-6
    reach = c.limit_px_s * window_s
    area_px = (width + reach) * (height + reach)

    def thinned(number: int) -> WarpedEvents:
        points = centred_points(
            events,
            most=number,
            middle_us=(from_us + to_us) / 2,
            middle_px=((width - 1) / 2, (height - 1) / 2),
        )
        return WarpedEvents(points, reward=c.reward, area_px=area_px)

    warped = thinned(c.most_events)
    limits = {"window_s": window_s, "limit_px_s": c.limit_px_s}
    if start is not None:
        glance = thinned(_WARM_SCAN_EVENTS)
        velocity = search_warm(warped.rewards, glance.rewards, start, **limits)
        found = with_prominence(warped, velocity, is_cold=False)
        if found.prominence >= c.prominence_floor and math.hypot(*velocity) <= c.limit_px_s:
            return found
    survey = thinned(_COLD_SCAN_EVENTS)
    velocity = search_cold(warped.rewards, cold_scan_at=survey.rewards, **limits)
    return with_prominence(warped, velocity, is_cold=True)


def with_prominence(warped: WarpedEvents, velocity: Velocity, *, is_cold: bool) -> ContrastEstimate:
    """Return the estimate for a velocity, with its reward and prominence."""
    reward = float(warped.rewards(np.array([velocity]), 1.0)[0])
    by_chance = warped.rewards_by_chance(velocity, 1.0, _random_orders(warped.number))
    return ContrastEstimate(velocity, reward, _standard_score(reward, by_chance), is_cold)


@lru_cache(maxsize=2)
def _random_orders(number: int) -> npt.NDArray[np.int32]:
    """Return random orders of events, (shuffles, number); they depend on the number alone.

    They are cached because most windows have `most_events` events.
    """
    rng = np.random.default_rng(0)
    return np.stack([rng.permutation(number) for _ in range(_SHUFFLES)]).astype(np.int32)


def _standard_score(value: float, others: npt.NDArray[np.float64]) -> float:
    spread = float(np.std(others, ddof=1))
    return (value - float(np.mean(others))) / spread if spread > 0.0 else 0.0


def _needed_bytes(config: ContrastConfig, width: int, height: int) -> int:
    """Return the memory of a search without the events before they are thinned [bytes]."""
    reach_px = math.ceil(config.limit_px_s * config.window_us * 1e-6)
    image = (width + reach_px) * (height + reach_px)
    candidates = (reach_px // 2 + 3) ** 2
    return 6 * image + 50 * candidates + (16 * _SHUFFLES + 50) * config.most_events


class ContrastMaximisation(WindowedDetector):
    """Contrast maximisation as a `Detector`, on a window of events at every hop.

    Its response is the image velocity [px/s]; hs and vs are its components relative to
    `limit_px_s`. It has no attention: its view centre is the image centre.

    Attributes:
        config: parameters.
        memory_us: age of the oldest event in an estimate: the window [µs].
    """

    def __init__(
        self, config: ContrastConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 with an empty window.

        Args:
            config: parameters; None: the defaults.
            width: sensor columns [px].
            height: sensor rows [px].

        Raises:
            MemoryBudgetError: the sensor, or the distance that the highest speed covers in a
                window, is too large for the memory budget.
        """
        self.config = c = config or ContrastConfig()
        super().__init__(c.hop_us, c.window_us, width=width, height=height)
        name = f"Contrast maximisation on {width}×{height} px"
        count_memory(self, name, _needed_bytes(c, width, height))
        self.memory_us = c.window_us
        hops = c.window_us // c.hop_us
        self._window = deque([empty_events()] * hops, maxlen=hops)
        self._previous: Velocity | None = None

    def _estimate(self, end_us: int, events: Events) -> MotionEstimate:
        c = self.config
        self._window.append(events)
        found = self._maximise(concatenate_events(self._window), end_us)
        if found is None or found.prominence < c.prominence_floor:
            self._previous = None
        elif c.warm_start:
            self._previous = found.velocity_px_s
        return velocity_estimate(
            end_us,
            found.velocity_px_s if found is not None else (0.0, 0.0),
            limit_px_s=c.limit_px_s,
            ratio=found.prominence if found is not None else 0.0,
            ratio_floor=c.prominence_floor,
            image_centre_px=(self._width / 2, self._height / 2),
        )

    def _maximise(self, events: Events, end_us: int) -> ContrastEstimate | None:
        """Return the velocity of highest reward in the window that ends at a time [µs]."""
        return maximise_contrast(
            events,
            from_us=end_us - self.config.window_us,
            to_us=end_us,
            width=self._width,
            height=self._height,
            config=self.config,
            start=self._previous,
        )
