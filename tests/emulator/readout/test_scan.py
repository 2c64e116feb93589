from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from emulator import EventSensor, ReadoutConfig, ReadoutKind, ReadoutStats
from emulator.readout.event_keys import MAX_STEP_US, TIME_SHIFT
from emulator.readout.scan import Scan
from tests.emulator.stimuli import intervals_us, moving_texture, noisy_config

Event = tuple[int, int]
"""Time [µs] and pixel."""


def run_scan(
    events: list[Event], bounds: list[int], *, period_us: int, latency_us: int = 0
) -> tuple[list[Event], list[ReadoutStats]]:
    """Read events out, step by step."""
    scan = Scan(period_us=period_us, latency_us=latency_us)
    out: list[Event] = []
    all_stats = []
    for a, b in pairwise(bounds):
        keys = sorted(((t - a) << TIME_SHIFT) | (p << 3) for t, p in events if a < t <= b)
        stamped, stats = scan.read_out(np.array(keys, np.int64), from_us=a, to_us=b)
        assert np.all(np.diff(stamped) > 0)
        found = [(a + (int(key) >> TIME_SHIFT), (int(key) >> 3) & (2**30 - 1)) for key in stamped]
        assert all(a < t <= b for t, _ in found)
        out += found
        all_stats.append(stats)
    return out, all_stats


event_lists = st.lists(st.tuples(st.integers(1, 60), st.integers(0, 9)), max_size=60, unique=True)


@given(event_lists, st.lists(st.integers(1, 99), max_size=8, unique=True), st.integers(1, 40))
def test_each_scan_reads_one_event_of_each_pixel(
    events: list[Event], cuts: list[int], period_us: int
) -> None:
    expected = {(-(-t // period_us) * period_us, pixel) for t, pixel in events}
    found, stats = run_scan(events, [0, *sorted(cuts), 100, 200], period_us=period_us)
    assert found == sorted(expected)
    assert sum(s.offered for s in stats) == len(events)
    assert sum(s.dropped for s in stats) == len(events) - len(found)
    assert stats[-1].waiting == 0
    assert all(s.delay_max_us < period_us for s in stats)


def test_the_first_event_of_a_pixel_is_kept_and_later_ones_are_dropped() -> None:
    scan = Scan(period_us=100, latency_us=0)
    keys = [(10 << TIME_SHIFT) | (5 << 3) | 1, (20 << TIME_SHIFT) | (5 << 3)]
    waiting, stats = scan.read_out(np.array(keys, np.int64), from_us=0, to_us=50)
    assert (waiting.size, stats.waiting, stats.dropped) == (0, 1, 1)
    late = np.array([(5 << TIME_SHIFT) | (5 << 3)], np.int64)
    found, stats = scan.read_out(late, from_us=50, to_us=150)
    assert found.tolist() == [(50 << TIME_SHIFT) | (5 << 3) | 1]
    assert (stats.waiting, stats.dropped, stats.delayed, stats.delay_max_us) == (0, 1, 1, 90)


def test_latency_delays_every_event() -> None:
    events = [(t, 3 * t % 192) for t in range(1, 100, 7)]
    prompt, _ = run_scan(events, [0, 50, 1000], period_us=20)
    late, _ = run_scan(events, [0, 50, 1000], period_us=20, latency_us=33)
    assert late == [(t + 33, p) for t, p in prompt]


def test_the_longest_step_and_the_longest_period_fit_into_a_key() -> None:
    events = [(MAX_STEP_US, 2**30 - 1), (MAX_STEP_US - 1, 0)]
    found, _ = run_scan(events, [0, MAX_STEP_US, MAX_STEP_US + 10**6], period_us=10**6)
    assert found == [(1_074_000_000, 0), (1_074_000_000, 2**30 - 1)]


def test_a_scanning_sensor_stamps_events_at_its_period() -> None:
    readout = ReadoutConfig(kind=ReadoutKind.SCAN, scan_period_us=194)
    sensor = EventSensor(noisy_config(readout=readout), seed=1)
    events = np.concatenate([sensor.step(t, f).events for t, f in moving_texture(60)])
    assert events.size > 500
    assert np.all(events["t"] % 194 == 0)
    assert intervals_us(events).min() >= 194
