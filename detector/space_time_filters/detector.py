"""Space-time filters: motion energy of events, normalised by the activity around each point.

T. Brosch, S. Tschechne and H. Neumann, "On event-based optical flow detection", Frontiers in
Neuroscience 9:137, 2015. Filters that fit receptive fields of the visual cortex respond to the
events of one direction and speed; each response is divided by those around it. The paper shows one
speed, 12.2 px/s, and how another follows from μ_bi1 (table 1). This bank has six, up to those of
the fly. The paper stops at the responses of each point; the estimate is the sum of their vectors.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from detector.decision import population_estimate
from detector.errors import DetectorConfigError
from detector.estimate import MotionEstimate
from detector.space_time_filters.bank import CELL_PX, DIRECTIONS, FilterBank, Normalisation
from detector.windowed import WindowedDetector, check_whole_hops
from flybench.checks import Range, check_ranges
from flybench.events import Events, concatenate_events
from flybench.memory import count_memory

__all__ = ["SpaceTimeFilters", "SpaceTimeFiltersConfig"]

F64 = npt.NDArray[np.float64]

SPEEDS = 6
"""Number of preferred speeds, each twice the one before (assumed). A temporal filter is wider than
an octave."""


_BYTES_PER_PX = 600
"""Memory per pixel of the sensor (at most 500 while they are made, measured at 346×260) [bytes]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SpaceTimeFiltersConfig:
    """Parameters of `SpaceTimeFilters`. No value was chosen on the sequences used for evaluation.

    Attributes:
        slowest_px_s: lowest preferred speed [px/s]; each of the other five is twice the one before.
            50: 50 to 1600 px/s, about the range of the fly (assumed).
        sigma: σ of the Gabor filters, whose standard deviation is σ / 2π [px]. The paper's.
        frequency: spatial frequency f₀ of the Gabor filters [1/px]. The paper's.
        beta: β of the normalisation. The paper's.
        alpha_p: α_p of the normalisation. The paper's.
        alpha_q: α_q of the normalisation. The paper's.
        pool_sigma_px: standard deviation of the normalisation's pool [px]. The paper's.
        window_us: span of the responses of one estimate [µs]. Δt of the event-driven fly.
        hop_us: step between estimates and between responses [µs]; the window is a multiple of it.
            That of the event-driven fly.
        snr_floor: least ratio of the summed opponent responses to the sum that random signs would
            give. 3, as for the fly: in synthetic noise of 0.1 to 20 Hz per pixel it reaches 1.7
            (assumed).

    Raises:
        DetectorConfigError: a value has the wrong type or is out of range.
    """

    slowest_px_s: float = 50.0
    sigma: float = 25.0
    frequency: float = 0.08
    beta: float = 1.0
    alpha_p: float = 0.1
    alpha_q: float = 0.002
    pool_sigma_px: float = 3.6
    window_us: int = 50_000
    hop_us: int = 10_000
    snr_floor: float = 3.0

    def __post_init__(self) -> None:
        """Check every value and convert it to its type."""
        check_ranges(self, _RANGES, DetectorConfigError)
        check_whole_hops(self.hop_us, window_us=self.window_us)


_RANGES: dict[str, Range] = {
    "slowest_px_s": Range(0.1, 100_000.0),
    "sigma": Range(1.0, 1e4),
    "frequency": Range(1e-4, 0.25),
    "beta": Range(1e-6, 1e6),
    "alpha_p": Range(1e-9, 1e6),
    "alpha_q": Range(1e-9, 1e6),
    "pool_sigma_px": Range(0.1, 1e4),
    "window_us": Range(1000, 10_000_000),
    "hop_us": Range(1000, 10_000_000),
    "snr_floor": Range(0.0, 1e6),
}


class SpaceTimeFilters(WindowedDetector):
    """Space-time filters as a `Detector`: the summed vectors of their responses at every hop.

    Its response is the sum of rightward minus leftward and downward minus upward normalised
    responses; hs and vs are these as shares of the sum of all. It has no attention: its view centre
    is the image centre.

    Attributes:
        config: parameters.
        memory_us: age of the oldest event in an estimate: one that the slowest filter still sees at
            the start of the window [µs].
    """

    def __init__(
        self, config: SpaceTimeFiltersConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 without events.

        Args:
            config: parameters; None: the defaults.
            width: sensor columns [px].
            height: sensor rows [px].

        Raises:
            DetectorConfigError: the sensor is smaller than a cell.
        """
        self.config = c = config or SpaceTimeFiltersConfig()
        if min(width, height) < CELL_PX:
            raise DetectorConfigError(
                f"The sensor has {width}×{height} px. Allowed are at least {CELL_PX} px per side, "
                "a cell of the filters. Use a larger sensor."
            )
        super().__init__(c.hop_us, c.window_us, width=width, height=height)
        count_memory(
            self, f"Space-time filters on {width}×{height} px", _BYTES_PER_PX * width * height
        )
        speeds_px_s = c.slowest_px_s * 2.0 ** np.arange(SPEEDS, dtype=np.float64)
        size = {"width": width, "height": height}
        self._bank = FilterBank(speeds_px_s, sigma=c.sigma, frequency=c.frequency, **size)
        self._normalise = Normalisation(
            beta=c.beta,
            alpha_p=c.alpha_p,
            alpha_q=c.alpha_q,
            sigma_px=c.pool_sigma_px,
            shape=self._bank.shape,
        )
        longest_us = int(self._bank.support_us.max())
        self.memory_us = c.window_us + longest_us
        self._events: deque[Events] = deque(maxlen=math.ceil(longest_us / c.hop_us))
        self._window: deque[F64] = deque(maxlen=c.window_us // c.hop_us)

    def _estimate(self, end_us: int, events: Events) -> MotionEstimate:
        self._events.append(events)
        responses = self._bank.responses(concatenate_events(self._events), end_us)
        self._window.append(self._normalise(responses).sum(axis=0, dtype=np.float64))
        by_direction = np.sum(self._window, axis=0)
        rightward, downward = vector_sum(by_direction)
        return population_estimate(
            end_us,
            rightward=rightward,
            downward=downward,
            total=float(by_direction.sum()),
            snr_floor=self.config.snr_floor,
            image_centre_px=(self._width / 2, self._height / 2),
        )


def vector_sum(responses: F64) -> tuple[F64, F64]:
    """Return the vectors of the responses of all directions (equation 33).

    Args:
        responses: (directions, rows, columns).

    Returns:
        Rightward and downward components, each (rows, columns).
    """
    angles = np.arange(DIRECTIONS) * 2.0 * math.pi / DIRECTIONS
    rightward, downward = (np.tensordot(f(angles), responses, 1) for f in (np.cos, np.sin))
    return rightward, downward
