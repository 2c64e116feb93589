import math

import numpy as np
import pytest

from detector.time_difference.detector import TimeDifferenceConfig
from detector.time_difference.encoder import (
    DOWN,
    LEFT,
    RIGHT,
    UP,
    TimeDifferenceEncoders,
    cell_of_pixels,
    make_neuron,
    trigger_cells,
)
from flybench.events import EVENT_DTYPE, Events

UNTIL_US = 200_000
NEURON = make_neuron(
    synapse_us=20_000,
    membrane_us=10_000,
    capacitance_nf=0.25,
    threshold_mv=10.0,
    reset_mv=-25.0,
    weight_na=0.3,
    scale_per_na=40.0,
)


def burst(t_us: int, x: int, y: int) -> Events:
    """Return five events of one pixel at one time, which let its correlation cell fire."""
    events = np.zeros(5, EVENT_DTYPE)
    events["t"], events["x"], events["y"], events["p"] = t_us, x, y, True
    return events


def spikes_of(*bursts: Events, width: int = 3, height: int = 3) -> np.ndarray:
    """Return the spikes of each direction, summed over encoders with cells of 1 px."""
    encoders = TimeDifferenceEncoders(NEURON, 1, width=width, height=height)
    events = np.sort(np.concatenate(bursts), order="t", kind="stable")
    return np.asarray(encoders.run(events, 0, UNTIL_US).sum(axis=(1, 2)))


@pytest.mark.parametrize(
    ("direction", "first", "then"),
    [
        (RIGHT, (0, 1), (1, 1)),
        (LEFT, (2, 1), (1, 1)),
        (DOWN, (1, 0), (1, 1)),
        (UP, (1, 2), (1, 1)),
    ],
)
def test_only_the_encoder_of_the_direction_fires(
    direction: int, first: tuple[int, int], then: tuple[int, int]
) -> None:
    # Two events let a cell fire once.
    spikes = spikes_of(burst(10_000, *first)[:2], burst(22_000, *then)[:2])
    assert spikes[direction] > 0
    assert spikes.sum() == spikes[direction]


def test_the_shorter_the_time_the_more_spikes() -> None:
    numbers = [
        int(spikes_of(burst(10_000, 0, 1)[:2], burst(10_000 + ms * 1000, 1, 1)[:2])[RIGHT])
        for ms in (4, 16, 32, 48, 90)
    ]
    assert numbers == sorted(numbers, reverse=True)
    assert numbers[0] > numbers[2] > numbers[-1] == 0


def test_events_at_one_time_have_no_direction() -> None:
    spikes = spikes_of(*(burst(10_000, x, y) for x in range(3) for y in range(3)))
    assert spikes[RIGHT] == spikes[LEFT]
    assert spikes[DOWN] == spikes[UP]


def test_a_single_event_makes_no_cell_fire() -> None:
    one, other = burst(10_000, 0, 1)[:1], burst(20_000, 1, 1)[:1]
    assert spikes_of(one, other).sum() == 0


def plain_pair(first_ms: list[int], second_ms: list[int], events_each: int) -> tuple[int, int]:
    """Return the spikes of the two encoders of a pair of cells, from the paper's equations."""
    kept, leak = math.exp(-1 / 20), math.exp(-1 / 10)
    current = dict.fromkeys(("a", "b", "ab", "ba"), 0.0)
    potential, trace, spiked = dict(current), {"a": 0.0, "b": 0.0}, {"a": False, "b": False}
    number = {"ab": 0, "ba": 0}

    def fires(name: str) -> bool:
        potential[name] = potential[name] * leak + 40.0 * current[name] * (1 - leak)
        is_spike = potential[name] > 10.0
        potential[name] = -25.0 if is_spike else potential[name]
        return is_spike

    for ms in range(UNTIL_US // 1000):
        for name, times in (("a", first_ms), ("b", second_ms)):
            trace[name] = trace[name] * kept + (0.3 if spiked[name] else 0.0)
            current[name] = current[name] * kept + 0.3 * events_each * (ms in times)
            spiked[name] = fires(name)
        for facilitator, trigger in (("a", "b"), ("b", "a")):
            name = facilitator + trigger
            current[name] *= kept
            if spiked[trigger]:
                current[name] += 0.3 * 40.0 * trace[facilitator]
            number[name] += fires(name)
    return number["ab"], number["ba"]


def test_the_encoders_equal_a_plain_loop() -> None:
    first_ms, second_ms = [5, 30, 31, 70, 120], [11, 28, 60, 75, 118]
    bursts = [burst(ms * 1000 + 300, 0, 0) for ms in first_ms]
    bursts += [burst(ms * 1000 + 700, 1, 0) for ms in second_ms]
    spikes = spikes_of(*bursts, width=2, height=1)
    expected = plain_pair(first_ms, second_ms, events_each=5)
    assert min(expected) > 0
    assert (spikes[RIGHT], spikes[LEFT]) == expected
    assert spikes[UP] == spikes[DOWN] == 0


def test_the_default_neuron_is_that_of_the_published_code() -> None:
    c = TimeDifferenceConfig()
    assert (
        make_neuron(
            synapse_us=c.synapse_us,
            membrane_us=c.membrane_us,
            capacitance_nf=c.capacitance_nf,
            threshold_mv=c.threshold_mv,
            reset_mv=c.reset_mv,
            weight_na=c.weight_na,
            scale_per_na=c.scale_per_na,
        )
        == NEURON
    )


def test_cells_are_centred() -> None:
    cells = cell_of_pixels(2, width=7, height=4)
    np.testing.assert_array_equal(cells[0], [0, 0, 1, 1, 1, 2, 2])
    np.testing.assert_array_equal(cells[:, 0], [0, 0, 3, 3])
    wide = cell_of_pixels(4, width=10, height=4)
    np.testing.assert_array_equal(wide[0], [-1, 0, 0, 0, 0, 1, 1, 1, 1, -1])


def test_triggers_are_the_neighbours() -> None:
    np.testing.assert_array_equal(trigger_cells(2, 3, 1, 0), [1, 2, -1, 4, 5, -1])
    np.testing.assert_array_equal(trigger_cells(2, 3, 0, -1), [-1, -1, -1, 0, 1, 2])
