"""Time difference encoders: spiking elementary motion detectors between neighbouring cells.

M. B. Milde, O. J. N. Bertrand, H. Ramachandran, M. Egelhaaf and E. Chicca, "Spiking elementary
motion detector in neuromorphic systems", Neural Computation 30 (9), 2018; G. D'Angelo, E. Janotte,
T. Schoepe, J. O'Keeffe, M. B. Milde, E. Chicca and C. Bartolozzi, "Event-based eccentric motion
detection exploiting time difference encoding", Frontiers in Neuroscience 14:451, 2020. This is the
network with cells of one size, which the latter compares with its eccentric cells. In place of its
layer of cleaning neurons, the spikes of opposite encoders of a cell are subtracted.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from detector.decision import population_estimate
from detector.errors import DetectorConfigError
from detector.estimate import MotionEstimate
from detector.time_difference.encoder import (
    DOWN,
    LEFT,
    RIGHT,
    STEP_US,
    UP,
    TimeDifferenceEncoders,
    make_neuron,
)
from detector.windowed import WindowedDetector, check_whole_hops
from flybench.checks import Range, check_ranges
from flybench.events import Events
from flybench.memory import count_memory

__all__ = ["TimeDifference", "TimeDifferenceConfig"]


_BYTES_PER_PX = 100
"""Memory per pixel of the sensor (measured: 69) [bytes]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeDifferenceConfig:
    """Parameters of `TimeDifference`. No value was chosen on the sequences used for evaluation.

    "Published code" is that of D'Angelo et al. (event-driven-robotics/sEMD-iCub).

    Attributes:
        cell_px: side of the square of a correlation cell [px]. 2: the paper has 1 px at the fovea
            and up to 10 px around it, the published code for equal cells 4. On synthetic textures
            of 60 to 1000 px/s, 1 and 2 gave at least 83 % right steps, and 4 as few as 0 %.
        synapse_us: time constant of all synaptic currents and of the facilitator's trace [µs].
            Published code.
        membrane_us: time constant of the membranes [µs]. Published code.
        capacitance_nf: capacitance of the membranes [nF]. Published code.
        threshold_mv: potential, above rest, at which a neuron fires [mV]. Published code: −50 mV,
            with a rest of −60 mV.
        reset_mv: potential, above rest, after a spike [mV]. Published code: −85 mV.
        weight_na: current of a spike [nA]. Published code.
        scale_per_na: factor of the product of facilitator and trigger [1/nA]. 40, the default of
            the neuron model of sPyNNaker, which the published code runs on (assumed).
        window_us: span of the spikes of one estimate [µs]. Δt of the event-driven fly.
        hop_us: step between estimates [µs], a multiple of 1 ms; the window is a multiple of it.
            That of the event-driven fly.
        snr_floor: least ratio of the summed opponent responses of the cells to the sum that random
            signs would give. 3, as for the fly: in synthetic noise of 0.1 to 20 Hz per pixel it
            reaches 2.2 (assumed).

    Raises:
        DetectorConfigError: a value has the wrong type or is out of range.
    """

    cell_px: int = 2
    synapse_us: int = 20_000
    membrane_us: int = 10_000
    capacitance_nf: float = 0.25
    threshold_mv: float = 10.0
    reset_mv: float = -25.0
    weight_na: float = 0.3
    scale_per_na: float = 40.0
    window_us: int = 50_000
    hop_us: int = 10_000
    snr_floor: float = 3.0

    def __post_init__(self) -> None:
        """Check every value and convert it to its type."""
        check_ranges(self, _RANGES, DetectorConfigError)
        check_whole_hops(self.hop_us, window_us=self.window_us)
        if self.hop_us % STEP_US:
            raise DetectorConfigError(
                f"hop_us is {self.hop_us} µs. Allowed is a multiple of {STEP_US} µs, the step of "
                "the neurons. Choose a whole number of milliseconds."
            )


_RANGES: dict[str, Range] = {
    "cell_px": Range(1, 1000),
    "synapse_us": Range(1, 10_000_000),
    "membrane_us": Range(1, 10_000_000),
    "capacitance_nf": Range(1e-3, 1e3),
    "threshold_mv": Range(0.1, 1e3),
    "reset_mv": Range(-1e3, 0.0),
    "weight_na": Range(1e-3, 1e3),
    "scale_per_na": Range(1e-3, 1e3),
    "window_us": Range(1000, 10_000_000),
    "hop_us": Range(1000, 10_000_000),
    "snr_floor": Range(0.0, 1e6),
}

_TRACES = 5
"""Time constants after which less than 1 % of a trace remains."""


class TimeDifference(WindowedDetector):
    """Time difference encoders as a `Detector`: the spikes of a window at every hop.

    Its response is the number of rightward minus leftward and downward minus upward spikes; hs and
    vs are these as shares of all spikes. It has no attention: its view centre is the image centre.

    Attributes:
        config: parameters.
        memory_us: age of the oldest event in an estimate: one whose trace has decayed at the start
            of the window [µs].
    """

    def __init__(
        self, config: TimeDifferenceConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 at rest.

        Args:
            config: parameters; None: the defaults.
            width: sensor columns [px].
            height: sensor rows [px].

        Raises:
            DetectorConfigError: the sensor has no two cells in a row or column.
        """
        self.config = c = config or TimeDifferenceConfig()
        if min(width, height) < 2 * c.cell_px:
            raise DetectorConfigError(
                f"The sensor has {width}×{height} px and cell_px is {c.cell_px}. Allowed are cells "
                "of which two fit into each side. Choose a smaller cell_px."
            )
        super().__init__(c.hop_us, c.window_us, width=width, height=height)
        count_memory(
            self, f"Time difference encoders on {width}×{height} px", _BYTES_PER_PX * width * height
        )
        self.memory_us = c.window_us + _TRACES * c.synapse_us
        neuron = make_neuron(
            synapse_us=c.synapse_us,
            membrane_us=c.membrane_us,
            capacitance_nf=c.capacitance_nf,
            threshold_mv=c.threshold_mv,
            reset_mv=c.reset_mv,
            weight_na=c.weight_na,
            scale_per_na=c.scale_per_na,
        )
        self._encoders = TimeDifferenceEncoders(neuron, c.cell_px, width=width, height=height)
        hops = c.window_us // c.hop_us
        self._window = deque([np.zeros((4, *self._encoders.shape), np.int64)] * hops, maxlen=hops)

    def _estimate(self, end_us: int, events: Events) -> MotionEstimate:
        c = self.config
        self._window.append(self._encoders.run(events, end_us - c.hop_us, end_us))
        spikes = np.sum(self._window, axis=0).astype(np.float64)
        return population_estimate(
            end_us,
            rightward=spikes[RIGHT] - spikes[LEFT],
            downward=spikes[DOWN] - spikes[UP],
            total=float(spikes.sum()),
            snr_floor=c.snr_floor,
            image_centre_px=(self._width / 2, self._height / 2),
        )
