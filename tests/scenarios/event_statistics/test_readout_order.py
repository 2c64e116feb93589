from dataclasses import astuple

import numpy as np
import pytest

from flybench.events import EVENT_DTYPE, Events
from scenarios.event_statistics.readout_order import ReadoutOrder, ReadoutShares
from tests.scenarios.event_statistics.made_events import events_of


def order_of(*blocks: Events) -> tuple[ReadoutShares, ...]:
    order = ReadoutOrder()
    for block in blocks:
        order.add(block)
    return order.shares()


def rows_at(*rows: int) -> Events:
    """One event per time stamp, in these rows."""
    return events_of(*((t, 3, row, 1) for t, row in enumerate(rows)))


def test_a_sweep_goes_downwards_to_the_neighbour() -> None:
    (slow, *_) = order_of(rows_at(*range(10)))
    assert astuple(slow) == (0.0, 10, 9, 1.0, 0.0, 1.0, 1.0)


def test_directions_and_distances_of_the_steps() -> None:
    (slow, *_) = order_of(rows_at(4, 5, 3, 9, 8))
    assert (slow.steps, slow.to_neighbour, slow.down) == (4, 0.5, 0.5)


def test_a_row_that_is_read_over_several_time_stamps() -> None:
    (slow, *_) = order_of(rows_at(4, 4, 4, 9, 2, 2))
    assert slow.continued == pytest.approx(5 / 6)
    assert (slow.steps, slow.down) == (2, 0.5)


def test_a_time_stamp_of_several_rows_takes_part_in_no_step() -> None:
    stream = events_of((0, 1, 4, 1), (1, 1, 5, 1), (1, 2, 6, 1), (2, 1, 7, 0), (2, 9, 7, 0))
    (slow, *_) = order_of(stream)
    assert (slow.stamps, slow.steps) == (3, 0)
    assert slow.one_row == pytest.approx(2 / 3)
    assert slow.to_neighbour is slow.down is None


def test_each_millisecond_belongs_to_the_class_of_its_rate() -> None:
    events = np.zeros(1500 + 10, EVENT_DTYPE)
    events["t"][:1500] = np.arange(1500) % 1000  # 1.5 Mev/s
    events["t"][1500:] = 1000 + np.arange(10)
    events = np.sort(events, order="t")
    by_load = {order.from_mev_s: order.stamps for order in order_of(events)}
    assert by_load == {0.0: 10, 0.5: 0, 1.0: 1000, 2.0: 0, 4.0: 0, 8.0: 0}


def test_blocks_change_nothing() -> None:
    rng = np.random.default_rng(1)
    events = np.zeros(20_000, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, 12_000, events.size))
    events["y"] = rng.integers(0, 24, events.size)
    assert order_of(events) == order_of(*np.array_split(events, 31))


def test_no_events_have_no_shares() -> None:
    assert all(order.one_row is None for order in order_of())
