"""Directions, speeds and delays of the synapses of the first layer of neurons."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

DIRECTIONS = 8
"""Number of preferred directions; direction d is d · 45° from right to down (Orchard et al.)."""
SPEEDS = 8
"""Number of preferred speeds, each √2 times the one before (Orchard et al.)."""
SIDE_1, SIDE_2 = 3, 5
"""Sides of the receptive fields of the two layers [px] (published code)."""

F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]


class Synapses(NamedTuple):
    """Synapses of the first layer, in groups of one speed and delay.

    A neuron receives a spike from the pixel (dx, dy) away from it.

    Attributes:
        speed: index of the speed of each group.
        delay_us: delay of each group [µs].
        first: index of the first synapse of each group, and the number of synapses.
        direction: index of the direction of each synapse.
        dx: column of the pixel relative to the neuron [px].
        dy: row of the pixel relative to the neuron [px].
    """

    speed: I64
    delay_us: F64
    first: I64
    direction: I64
    dx: I64
    dy: I64


def preferred_speeds(slowest_px_s: float) -> F64:
    """Return the preferred speeds [px/s], slowest first."""
    return np.asarray(slowest_px_s * math.sqrt(2.0) ** np.arange(SPEEDS))


def preferred_directions() -> F64:
    """Return the unit vectors (x, y) of the preferred directions, (directions, 2)."""
    angles = np.arange(DIRECTIONS) * 2.0 * math.pi / DIRECTIONS
    return np.stack([np.cos(angles), np.sin(angles)], axis=1).round(12)


def path_lengths() -> F64:
    """Return how far an edge still has to go when it passes each pixel of a receptive field [px].

    Returns:
        (directions, rows, columns) float64; 0 for the pixel that the edge passes last. Divided by
        the speed, these are the delays with which all spikes of one edge arrive at the same time.
    """
    reach = np.arange(SIDE_1) - SIDE_1 // 2
    ux, uy = preferred_directions().T
    along = ux[:, None, None] * reach + uy[:, None, None] * reach[:, None]
    return np.asarray((along.max(axis=(1, 2), keepdims=True) - along).round(9))


def make_synapses(slowest_px_s: float) -> Synapses:
    """Return the synapses of the first layer.

    Args:
        slowest_px_s: lowest preferred speed [px/s].
    """
    lengths = path_lengths()
    speed, delay_us, first, at = [], [], [0], []
    for s, speed_px_s in enumerate(preferred_speeds(slowest_px_s)):
        for length in np.unique(lengths):
            speed.append(s)
            delay_us.append(length / speed_px_s * 1e6)
            at.append(np.argwhere(lengths == length))
            first.append(first[-1] + len(at[-1]))
    direction, row, column = np.concatenate(at).T
    half = SIDE_1 // 2
    return Synapses(
        *(np.array(speed), np.array(delay_us), np.array(first)),
        *(direction.astype(np.int64), column - half, row - half),
    )
