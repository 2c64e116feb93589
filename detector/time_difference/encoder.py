"""Neurons of the time difference encoder, in steps of 1 ms.

A correlation cell sums the events of a square of pixels and fires if several come together. Each
pair of neighbouring cells has one time difference encoder per direction. A spike of the cell that
the motion passes first, the facilitator, leaves a trace that decays. A spike of the other, the
trigger, then causes a current in proportion to the trace, so that the encoder fires the more often
the shorter the time between them. It does not fire for the opposite order.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from detector.cells import OUTSIDE, centred_cells
from flybench.events import Events
from flybench.kernels import compiled, inlined

STEP_US = 1_000
"""Step of the neurons [µs]; that of the authors' simulations."""
RIGHT, LEFT, DOWN, UP = range(4)
TRIGGERS = ((1, 0), (-1, 0), (0, 1), (0, -1))
"""Column and row of the trigger relative to the facilitator, for each direction."""

I64 = npt.NDArray[np.int64]


class Neuron(NamedTuple):
    """Parameters of all neurons; `TimeDifferenceConfig` explains each of them.

    Attributes:
        kept_current: share of a synaptic current that remains after a step.
        kept_potential: share of a potential that remains after a step.
        gain: potential that a constant current of 1 nA adds in a step [mV].
        threshold: potential, above rest, at which a neuron fires [mV].
        reset: potential, above rest, after a spike [mV].
        weight: current of a spike [nA].
        scale: factor of the product of facilitator and trigger [1/nA].
    """

    kept_current: float
    kept_potential: float
    gain: float
    threshold: float
    reset: float
    weight: float
    scale: float


def make_neuron(
    *,
    synapse_us: int,
    membrane_us: int,
    capacitance_nf: float,
    threshold_mv: float,
    reset_mv: float,
    weight_na: float,
    scale_per_na: float,
) -> Neuron:
    """Return the parameters of a neuron for steps of `STEP_US`, by exact integration."""
    kept_potential = math.exp(-STEP_US / membrane_us)
    resistance_mohm = membrane_us * 1e-3 / capacitance_nf
    return Neuron(
        kept_current=math.exp(-STEP_US / synapse_us),
        kept_potential=kept_potential,
        gain=resistance_mohm * (1.0 - kept_potential),
        threshold=threshold_mv,
        reset=reset_mv,
        weight=weight_na,
        scale=scale_per_na,
    )


class TimeDifferenceEncoders:
    """Correlation cells and time difference encoders of both polarities."""

    def __init__(self, neuron: Neuron, cell_px: int, *, width: int, height: int) -> None:
        """Start at rest.

        Args:
            neuron: parameters of all neurons.
            cell_px: side of the square of a correlation cell [px].
            width: sensor columns [px]; cells are centred, so that a rim and a
                pixel in the middle may belong to none.
            height: sensor rows [px].
        """
        rows, columns = height // cell_px, width // cell_px
        self.shape = (rows, columns)
        self._neuron = neuron
        self._cell_of = cell_of_pixels(cell_px, width=width, height=height)
        cells = rows * columns
        self._events = np.zeros((2, cells))
        self._cells = np.zeros((2, 3, cells))  # current, potential, trace of the facilitator
        self._spiked = np.zeros((2, cells), np.bool_)
        self._encoders = np.zeros((2, 4, 2, cells))  # current, potential
        self._triggers = np.stack([trigger_cells(rows, columns, *at) for at in TRIGGERS])

    def run(self, events: Events, from_us: int, until_us: int) -> I64:
        """Run over a span of whole steps and return how often each encoder fires.

        Args:
            events: sorted by t, all in the span.
            from_us: start [µs].
            until_us: end, exclusive [µs].

        Returns:
            (4, rows, columns) int64, spikes of both polarities by direction and facilitator.
        """
        spikes = np.zeros((4, self._events.shape[1]), np.int64)
        taken = 0
        for end_us in range(from_us + STEP_US, until_us + 1, STEP_US):
            taken = _count(events, taken, end_us, self._cell_of, self._events)
            for p in range(2):
                state = (self._cells[p], self._spiked[p], self._encoders[p])
                _step(self._events[p], self._triggers, self._neuron, state, spikes)
        return spikes.reshape(4, *self.shape)


def cell_of_pixels(cell_px: int, *, width: int, height: int) -> npt.NDArray[np.int32]:
    """Return the index of each pixel's cell, (height, width) int32; `OUTSIDE` for the rim."""
    rows, columns = height // cell_px, width // cell_px
    row, column = centred_cells(height, cell_px, rows), centred_cells(width, cell_px, columns)
    inside = (row != OUTSIDE)[:, None] & (column != OUTSIDE)
    return np.where(inside, row[:, None] * columns + column, OUTSIDE).astype(np.int32)


def trigger_cells(rows: int, columns: int, dx: int, dy: int) -> I64:
    """Return the index of the cell (dx, dy) away from each cell; `OUTSIDE` if there is none."""
    row, column = np.mgrid[:rows, :columns]
    row, column = row + dy, column + dx
    inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    return np.where(inside, row * columns + column, OUTSIDE).ravel()


@compiled
def _count(events: Any, taken: int, end_us: int, cell_of: Any, counts: Any) -> int:
    """Count the events of a step by cell, and return the index of the next event."""
    counts[:] = 0.0
    while taken < events.size and events[taken].t < end_us:
        event = events[taken]
        cell = cell_of[event.y, event.x]
        if cell != OUTSIDE:
            counts[int(event.p), cell] += 1.0
        taken += 1
    return taken


@compiled
def _step(counts: Any, triggers: Any, neuron: Any, state: Any, spikes: Any) -> None:
    """Advance all neurons of a polarity by one step.

    Spikes of the cells of the step before facilitate, those of this step trigger, so that events at
    one time have no direction.
    """
    (current, potential, trace), spiked, encoders = state
    for n in range(counts.size):
        trace[n] = trace[n] * neuron.kept_current + (neuron.weight if spiked[n] else 0.0)
        current[n] = current[n] * neuron.kept_current + neuron.weight * counts[n]
        potential[n], spiked[n] = _integrate(potential[n], current[n], neuron)
    for direction in range(4):
        currents, potentials = encoders[direction]
        for n in range(counts.size):
            trigger = triggers[direction, n]
            currents[n] *= neuron.kept_current
            if trigger != OUTSIDE and spiked[trigger]:
                currents[n] += neuron.weight * neuron.scale * trace[n]
            potentials[n], fires = _integrate(potentials[n], currents[n], neuron)
            spikes[direction, n] += fires


@inlined
def _integrate(potential: float, current: float, neuron: Any) -> tuple[float, bool]:
    """Return the potential of a leaky integrate-and-fire neuron after a step, and if it fires."""
    potential = potential * neuron.kept_potential + current * neuron.gain
    if potential > neuron.threshold:
        return neuron.reset, True
    return potential, False
