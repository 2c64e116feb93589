"""Two layers of spiking neurons with synaptic delays.

Every pixel has one neuron per direction and speed. In the first layer, which is separate for each
polarity, the spikes of an edge that moves with a neuron's velocity reach it together, because the
delays of its synapses make up for the time that the edge takes. The second layer has no delays. It
adds the spikes of neighbouring pixels, and those of edges that are oblique to the motion.

A potential decays linearly towards 0. A neuron is stored as the time at which it reaches 0,
negative if it comes from below, in 32 bits: the neurons are far more than fit into a cache, so that
speed is that of memory. For the same reason the neurons of one pixel and speed are neighbours.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from detector.spiking_delays.synapses import (
    DIRECTIONS,
    SIDE_1,
    SIDE_2,
    SPEEDS,
    make_synapses,
    preferred_speeds,
)
from flybench.events import Events
from flybench.kernels import compiled, inlined

I64 = npt.NDArray[np.int64]
F64 = npt.NDArray[np.float64]


class Rules(NamedTuple):
    """Parameters of the neurons of one layer.

    Attributes:
        weight: potential that a spike adds [mV].
        threshold: potential above which a neuron fires [mV].
        reset: potential of all neurons of a pixel after one of them has fired [mV].
        decay: loss of potential at each speed [mV/µs].
    """

    weight: float
    threshold: float
    reset: float
    decay: F64


def layer_rules(slowest_px_s: float) -> tuple[Rules, Rules]:
    """Return the parameters of both layers; every value is that of the published code.

    Args:
        slowest_px_s: lowest preferred speed [px/s].
    """
    per_us = preferred_speeds(slowest_px_s) * 1e-6
    first = Rules(100.0 / SIDE_1**2, 50.0, -128.0, 50.0 * per_us)
    return first, Rules(100.0 / SIDE_2**2, 60.0, -50.0, 60.0 / 100.0 * per_us)


_EPOCH_US = 8_000_000
"""Time after which the clock of the neurons is set to 0 [µs]: 32 bits then resolve 0.5 µs."""


class SpikingNetwork:
    """Two layers of neurons that read a stream of events.

    Spikes on their way through a delay are bounded: per speed and polarity, a pixel passes on one
    event at most during the longest delay.
    """

    def __init__(self, slowest_px_s: float, *, width: int, height: int) -> None:
        """Start at time 0 with all potentials at 0.

        Args:
            slowest_px_s: lowest preferred speed [px/s].
            width: sensor columns [px].
            height: sensor rows [px].
        """
        self._synapses = make_synapses(slowest_px_s)
        self._rules = layer_rules(slowest_px_s)
        image = (height, width, DIRECTIONS)
        self._first = np.zeros((2, SPEEDS, *image), np.float32)
        self._second = np.zeros((SPEEDS, *image), np.float32)
        self._epoch_us = 0
        longest_us = np.zeros(SPEEDS)
        np.maximum.at(longest_us, self._synapses.speed, self._synapses.delay_us)
        self._refractory_us = longest_us
        self._accepted_us = np.full((SPEEDS, 2, height, width), -(1 << 60), np.int64)
        self._waiting = np.empty((SPEEDS, 0, 4), np.int64)
        self._counts = np.zeros(SPEEDS, np.int64)
        self._heads = np.zeros(len(self._synapses.speed), np.int64)

    def run(self, events: Events, from_us: int, until_us: int) -> I64:
        """Read the next events and return how often the neurons of the second layer fire.

        Args:
            events: sorted by t, all in the span.
            from_us: start of the span, not before the end of the last one [µs].
            until_us: end of the span, exclusive [µs].

        Returns:
            (speeds, directions) int64, number of spikes.
        """
        spikes = np.zeros((SPEEDS, DIRECTIONS), np.int64)
        if from_us - self._epoch_us >= _EPOCH_US:
            self._pass_on(from_us, spikes)
            for neurons in (self._first, self._second):
                _turn_back(neurons.reshape(-1), from_us - self._epoch_us)
            self._epoch_us = from_us
        self._make_room(events.size)
        _accept(events, self._refractory_us, self._accepted_us, self._waiting, self._counts)
        self._pass_on(until_us, spikes)
        return spikes

    def _pass_on(self, until_us: int, spikes: I64) -> None:
        """Pass on the spikes that arrive before a time, and count those of the second layer."""
        layers, queue = (self._first, self._second), (self._waiting, self._counts, self._heads)
        times = (self._epoch_us, until_us - self._epoch_us)
        _run(times, self._synapses, self._rules, layers, queue, spikes)

    def _make_room(self, number: int) -> None:
        """Remove the events that all synapses have passed on, and make room for new ones."""
        passed = np.full(SPEEDS, np.iinfo(np.int64).max)
        np.minimum.at(passed, self._synapses.speed, self._heads)
        left = self._counts - passed
        room = np.empty((SPEEDS, int(left.max()) + number, 4), np.int64)
        for speed in range(SPEEDS):
            room[speed, : left[speed]] = self._waiting[speed, passed[speed] : self._counts[speed]]
        self._waiting, self._counts = room, left
        self._heads -= passed[self._synapses.speed]


@compiled
def _accept(events: Any, refractory_us: Any, accepted_us: Any, waiting: Any, counts: Any) -> None:
    """Append the events that find their pixel out of its refractory period, for each speed."""
    for n in range(events.size):
        event = events[n]
        t, x, y, p = int(event.t), int(event.x), int(event.y), int(event.p)
        for s in range(counts.size):
            if t - accepted_us[s, p, y, x] > refractory_us[s]:
                accepted_us[s, p, y, x] = t
                row = waiting[s, counts[s]]
                row[0], row[1], row[2], row[3] = t, x, y, p
                counts[s] += 1


@compiled
def _turn_back(neurons: Any, by_us: int) -> None:
    for n in range(neurons.size):
        neurons[n] = np.copysign(max(abs(neurons[n]) - np.float32(by_us), 0), neurons[n])


@compiled
def _run(times: Any, synapses: Any, rules: Any, layers: Any, queue: Any, spikes: Any) -> None:
    """Pass on all spikes that arrive before a time, in the order of their arrival.

    All synapses of a group have one delay, so that each group passes on the waiting events in
    their order, and only the next arrivals of the groups need to be compared.
    """
    epoch_us, until_us = times
    waiting, counts, heads = queue
    first, second = layers
    height, width = first.shape[2:4]
    neurons, dx, dy, direction = first.reshape(-1), synapses.dx, synapses.dy, synapses.direction
    groups = heads.size // SPEEDS
    arrivals, earliest = np.empty(heads.size), np.empty(SPEEDS)
    for g in range(heads.size):
        arrivals[g] = _next_arrival(g, synapses, waiting, counts, heads)
    for s in range(SPEEDS):
        earliest[s] = arrivals[s * groups : (s + 1) * groups].min()
    while True:
        s = _first_least(earliest)
        t_us = earliest[s] - epoch_us
        if t_us >= until_us:
            return
        g = s * groups + _first_least(arrivals[s * groups : (s + 1) * groups])
        at = waiting[s, heads[g]]
        event_x, event_y, plane = at[1], at[2], at[3] * SPEEDS + s
        rule = (rules[0].weight, rules[0].threshold, rules[0].decay[s])
        for k in range(synapses.first[g], synapses.first[g + 1]):
            x, y, d = event_x - dx[k], event_y - dy[k], direction[k]
            if 0 <= x < width and 0 <= y < height:
                neuron = ((plane * height + y) * width + x) * DIRECTIONS + d
                if _excite(neurons, neuron, t_us, rule):
                    _reset(first[at[3]], x, y, t_us, rules[0])
                    _second_layer(second, x, y, s, d, t_us, rules[1], spikes)
        heads[g] += 1
        arrivals[g] = _next_arrival(g, synapses, waiting, counts, heads)
        earliest[s] = arrivals[s * groups : (s + 1) * groups].min()


@inlined
def _first_least(values: Any) -> int:
    least = 0
    for n in range(1, values.size):
        least = n if values[n] < values[least] else least
    return least


@inlined
def _next_arrival(g: int, synapses: Any, waiting: Any, counts: Any, heads: Any) -> float:
    s = synapses.speed[g]
    if heads[g] == counts[s]:
        return np.inf
    return float(waiting[s, heads[g], 0] + synapses.delay_us[g])


@compiled
def _second_layer(
    neurons: Any, x: int, y: int, s: int, d: int, t_us: float, rules: Any, spikes: Any
) -> None:
    """Pass a spike of the first layer to the neurons around it, and count those that fire.

    They are the neurons of the same velocity, and those that an oblique edge may belong to, with a
    direction 45° away and a speed √2 times as high.
    """
    height, width = neurons.shape[1:3]
    flat, half = neurons.reshape(-1), SIDE_2 // 2
    for turn in range(-1, 2):
        speed, direction = s + abs(turn), (d + turn) % DIRECTIONS
        if speed == SPEEDS:
            continue
        rule = (rules.weight, rules.threshold, rules.decay[speed])
        for row in range(max(y - half, 0), min(y + half + 1, height)):
            for column in range(max(x - half, 0), min(x + half + 1, width)):
                neuron = ((speed * height + row) * width + column) * DIRECTIONS + direction
                if _excite(flat, neuron, t_us, rule):
                    _reset(neurons, column, row, t_us, rules)
                    spikes[speed, direction] += 1


@inlined
def _excite(neurons: Any, neuron: int, t_us: float, rule: Any) -> bool:
    """Add a spike to a neuron, and return True if it fires."""
    weight, threshold, decay = rule
    zero_us = float(neurons[neuron])
    potential = max(abs(zero_us) - t_us, 0.0) * decay
    potential = (potential if zero_us > 0.0 else -potential) + weight
    zero_us = t_us + abs(potential) / decay
    neurons[neuron] = zero_us if potential > 0.0 else -zero_us
    return bool(potential > threshold)


@compiled
def _reset(neurons: Any, x: int, y: int, t_us: float, rules: Any) -> None:
    """Reset all neurons of a pixel, which inhibit each other."""
    for speed in range(SPEEDS):
        neurons[speed, y, x, :] = -(t_us - rules.reset / rules.decay[speed])
