import math

import numpy as np
import pytest

from detector.spiking_delays import network
from detector.spiking_delays.network import SpikingNetwork, layer_rules
from detector.spiking_delays.synapses import (
    DIRECTIONS,
    SPEEDS,
    make_synapses,
    path_lengths,
    preferred_speeds,
)
from flybench.events import EVENT_DTYPE, Events
from tests.detector.stimuli import merged, noise

SLOWEST_PX_S = 100.0
WIDTH, HEIGHT = 9, 8


def test_an_edge_reaches_a_neuron_of_its_velocity_at_one_time() -> None:
    lengths = path_lengths()
    np.testing.assert_allclose(lengths[0], [[2, 1, 0]] * 3)  # rightward: the left column waits
    np.testing.assert_allclose(lengths[2], np.transpose([[2, 1, 0]] * 3))  # downward
    assert lengths[1, 0, 0] == pytest.approx(2 * math.sqrt(2))
    assert lengths[1, 2, 2] == 0


def test_speeds_are_a_factor_of_root_2_apart() -> None:
    assert preferred_speeds(28.3)[[0, 2, 7]] == pytest.approx([28.3, 56.6, 320.2], abs=0.1)


def test_every_neuron_has_one_synapse_per_pixel_of_its_field() -> None:
    s = make_synapses(SLOWEST_PX_S)
    speed = np.repeat(s.speed, np.diff(s.first))
    all_of_them = set(zip(speed, s.direction, s.dx, s.dy, strict=True))
    assert len(all_of_them) == len(speed) == SPEEDS * DIRECTIONS * 9
    assert s.first[-1] == len(speed)


class PlainNeuron:
    """One neuron, as the paper describes it: a potential and the time of its last change."""

    def __init__(self) -> None:
        self.potential = self.t_us = 0.0

    def excite(self, t_us: float, weight: float, decay: float) -> float:
        loss = (t_us - self.t_us) * decay
        size = max(abs(self.potential) - loss, 0.0)
        self.potential = math.copysign(size, self.potential) + weight
        self.t_us = t_us
        return self.potential


def plain_network(events: Events) -> np.ndarray:
    """Return the spikes of the second layer from a loop over all arrivals, sorted by time."""
    first, second = layer_rules(SLOWEST_PX_S)
    lengths, speeds = path_lengths(), preferred_speeds(SLOWEST_PX_S) * 1e-6
    arrivals: list[tuple[float, int, int, int, int, int]] = []
    accepted: dict[tuple[int, bool, int, int], int] = {}
    for t, x, y, p in events.tolist():
        for s in range(SPEEDS):
            longest_us = lengths.max() / speeds[s]
            if t - accepted.get((s, p, y, x), -1e9) <= longest_us:
                continue
            accepted[s, p, y, x] = t
            for d in range(DIRECTIONS):
                for row in range(3):
                    for column in range(3):
                        cx, cy = x - (column - 1), y - (row - 1)
                        if 0 <= cx < WIDTH and 0 <= cy < HEIGHT:
                            arrives_us = t + lengths[d, row, column] / speeds[s]
                            arrivals.append((arrives_us, int(p), cy, cx, s, d))
    shape = (SPEEDS, DIRECTIONS)
    layer_1 = np.array([PlainNeuron() for _ in range(2 * HEIGHT * WIDTH * 64)])
    layer_2 = np.array([PlainNeuron() for _ in range(HEIGHT * WIDTH * 64)])
    layer_1 = layer_1.reshape(2, HEIGHT, WIDTH, *shape)
    layer_2 = layer_2.reshape(HEIGHT, WIDTH, *shape)
    spikes = np.zeros(shape, np.int64)

    def fires(pixel: np.ndarray, s: int, d: int, t_us: float, rules: network.Rules) -> bool:
        if pixel[s, d].excite(t_us, rules.weight, rules.decay[s]) <= rules.threshold:
            return False
        for neuron in pixel.flat:
            neuron.potential, neuron.t_us = rules.reset, t_us
        return True

    for t_us, p, y, x, s, d in sorted(arrivals):
        if not fires(layer_1[p, y, x], s, d, t_us, first):
            continue
        for turn in (-1, 0, 1):
            speed, direction = s + abs(turn), (d + turn) % DIRECTIONS
            for row in range(max(y - 2, 0), min(y + 3, HEIGHT)):
                for column in range(max(x - 2, 0), min(x + 3, WIDTH)):
                    if speed < SPEEDS and fires(
                        layer_2[row, column], speed, direction, t_us, second
                    ):
                        spikes[speed, direction] += 1
    return spikes


def oblique_edges(number: int) -> Events:
    """Return the events of edges that move right and downwards at 150 px/s, with jitter."""
    rng = np.random.default_rng(5)
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    events = np.zeros((number, HEIGHT, WIDTH), EVENT_DTYPE)
    passes_us = (columns + rows / 3) / 150 * 1e6 + np.arange(number)[:, None, None] * 60_000
    events["t"] = passes_us + rng.uniform(0, 500, events.shape)
    events["x"], events["y"], events["p"] = columns, rows, np.arange(number)[:, None, None] % 2
    return np.sort(events.ravel(), order="t", kind="stable")


@pytest.mark.parametrize("noise_hz", [0.0, 20.0])
def test_the_network_equals_a_plain_loop_over_all_arrivals(noise_hz: float) -> None:
    size = {"width": WIDTH, "height": HEIGHT}
    events = merged(oblique_edges(8), noise(noise_hz, duration_us=500_000, **size))
    of_loop = plain_network(events)
    found = SpikingNetwork(SLOWEST_PX_S, width=WIDTH, height=HEIGHT).run(events, 0, 10_000_000)
    assert of_loop.sum() > 10
    np.testing.assert_array_equal(found, of_loop)


def test_neither_steps_nor_the_clock_of_the_neurons_change_a_spike() -> None:
    events = oblique_edges(8)
    whole = SpikingNetwork(SLOWEST_PX_S, width=WIDTH, height=HEIGHT).run(events, 0, 10**9)
    late = SpikingNetwork(SLOWEST_PX_S, width=WIDTH, height=HEIGHT)
    start_us = 7_750_000  # the neurons' clock is set to 0 while the edges pass
    events["t"] += start_us
    spikes = late.run(events[:0], 0, start_us)
    for until_us in range(start_us + 10_000, start_us + 1_000_000, 10_000):
        inside = (events["t"] >= until_us - 10_000) & (events["t"] < until_us)
        spikes += late.run(events[inside], until_us - 10_000, until_us)
    assert whole.sum() > 10
    np.testing.assert_array_equal(spikes, whole)


def test_memory_is_bounded_for_many_events_at_one_time() -> None:
    made = SpikingNetwork(SLOWEST_PX_S, width=WIDTH, height=HEIGHT)
    events = np.zeros(200_000, EVENT_DTYPE)
    events["t"], events["x"], events["y"] = 5_000, np.arange(200_000) % WIDTH, 3
    made.run(events, 0, 10_000)
    made.run(events[:0], 10_000, 20_000)
    assert made._waiting.shape[1] <= WIDTH
