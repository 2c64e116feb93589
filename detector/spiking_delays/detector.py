"""A spiking network with synaptic delays: 8 directions × 8 speeds at every pixel.

G. Orchard, R. Benosman, R. Etienne-Cummings and N. V. Thakor, "A spiking neural network
architecture for visual motion estimation", IEEE Biomedical Circuits and Systems Conference, 2013.
Parameters are those of the code that the authors published (gorchard/Spiking_Motion). The paper
stops at the spikes of the second layer, each of which stands for a velocity. The estimate is their
mean over a window.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from detector.decision import velocity_estimate
from detector.errors import DetectorConfigError
from detector.estimate import MotionEstimate
from detector.spiking_delays.network import SpikingNetwork
from detector.spiking_delays.synapses import (
    DIRECTIONS,
    SIDE_1,
    SPEEDS,
    preferred_directions,
    preferred_speeds,
)
from detector.windowed import WindowedDetector, check_whole_hops
from flybench.checks import Range, check_ranges
from flybench.events import Events
from flybench.memory import count_memory

__all__ = ["SpikingDelays", "SpikingDelaysConfig"]


_BYTES_PER_PX = 1000
"""Memory per pixel of the sensor (measured: 910) [bytes]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SpikingDelaysConfig:
    """Parameters of `SpikingDelays`. No value was chosen on the sequences used for evaluation.

    Attributes:
        slowest_px_s: lowest preferred speed [px/s]; each of the other seven is √2 times the one
            before. 28.3: 28.3 to 320 px/s, as in the published code.
        window_us: span of the spikes of one estimate [µs]. Δt of the event-driven fly.
        hop_us: step between estimates [µs]; the window is a multiple of it. That of the
            event-driven fly.
        least_spikes: least number of spikes for a direction (assumed).
        snr_floor: least ratio of the summed directions of the spikes to the sum that random
            directions would give. 5, as in `PlaneFitConfig` (assumed).

    Raises:
        DetectorConfigError: a value has the wrong type or is out of range.
    """

    slowest_px_s: float = 20.0 * math.sqrt(2.0)
    window_us: int = 50_000
    hop_us: int = 10_000
    least_spikes: int = 20
    snr_floor: float = 5.0

    def __post_init__(self) -> None:
        """Check every value and convert it to its type."""
        check_ranges(self, _RANGES, DetectorConfigError)
        check_whole_hops(self.hop_us, window_us=self.window_us)


_RANGES: dict[str, Range] = {
    "slowest_px_s": Range(0.1, 100_000.0),
    "window_us": Range(1000, 10_000_000),
    "hop_us": Range(1000, 10_000_000),
    "least_spikes": Range(1, 1_000_000),
    "snr_floor": Range(0.0, 1e6),
}


def mean_velocity(
    spikes: npt.NDArray[np.int64], slowest_px_s: float
) -> tuple[tuple[float, float], float]:
    """Return the mean velocity of spikes and how far they agree.

    Args:
        spikes: number of spikes of each velocity, (speeds, directions); at least one.
        slowest_px_s: lowest preferred speed [px/s].

    Returns:
        (x, y) of the mean velocity [px/s], and |Σu| / √Σu², in which u is the component of a
        spike's unit direction along the stronger of the two axes.
    """
    by_direction, directions = spikes.sum(axis=0), preferred_directions()
    sums = by_direction @ directions
    spread = np.sqrt(by_direction @ directions**2)
    axis = int(np.argmax(np.abs(sums)))
    ratio = float(abs(sums[axis]) / spread[axis]) if spread[axis] > 0.0 else 0.0
    vx, vy = preferred_speeds(slowest_px_s) @ spikes @ directions / spikes.sum()
    return (float(vx), float(vy)), ratio


class SpikingDelays(WindowedDetector):
    """A spiking network as a `Detector`: the mean velocity of its spikes at every hop.

    Its response is the image velocity [px/s]; hs and vs are its components relative to the highest
    preferred speed. It has no attention: its view centre is the image centre.

    Attributes:
        config: parameters.
        memory_us: age of the oldest event in an estimate: one that the longest delay holds back
            until the start of the window [µs].
    """

    def __init__(
        self, config: SpikingDelaysConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 without spikes.

        Args:
            config: parameters; None: the defaults.
            width: sensor columns [px].
            height: sensor rows [px].
        """
        self.config = c = config or SpikingDelaysConfig()
        super().__init__(c.hop_us, c.window_us, width=width, height=height)
        count_memory(
            self, f"A spiking network on {width}×{height} px", _BYTES_PER_PX * width * height
        )
        longest_path_px = (SIDE_1 - 1) * math.sqrt(2.0)
        self.memory_us = c.window_us + math.ceil(longest_path_px / c.slowest_px_s * 1e6)
        self._network = SpikingNetwork(c.slowest_px_s, width=width, height=height)
        hops = c.window_us // c.hop_us
        nothing = np.zeros((SPEEDS, DIRECTIONS), np.int64)
        self._window = deque([nothing] * hops, maxlen=hops)

    def _estimate(self, end_us: int, events: Events) -> MotionEstimate:
        c = self.config
        self._window.append(self._network.run(events, end_us - c.hop_us, end_us))
        spikes = np.sum(self._window, axis=0)
        velocity, ratio = (0.0, 0.0), 0.0
        if spikes.sum() >= c.least_spikes:
            velocity, ratio = mean_velocity(spikes, c.slowest_px_s)
        return velocity_estimate(
            end_us,
            velocity,
            limit_px_s=float(preferred_speeds(c.slowest_px_s)[-1]),
            ratio=ratio,
            ratio_floor=c.snr_floor,
            image_centre_px=(self._width / 2, self._height / 2),
        )
