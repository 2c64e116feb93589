"""The tree of arbiters on the whole sensor: order, conservation, the same output in any steps."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from emulator import EventSensor, Lines, ReadoutConfig, ReadoutKind, SensorConfig
from emulator.readout.arbiter import Arbiter
from emulator.readout.arbiter_tree import either
from emulator.readout.event_keys import PIXEL_MASK, TIME_SHIFT

WIDTH, HEIGHT = 346, 260
Longs = np.ndarray[tuple[int], np.dtype[np.int64]]


def offered(rate_mev_s: float, duration_us: int = 20_000) -> Longs:
    """Return random events as sorted keys, one row of time and pixel each."""
    rng = np.random.default_rng(3)
    number = round(rate_mev_s * duration_us)
    times = rng.integers(1, duration_us + 1, number)
    return np.unique((times << TIME_SHIFT) | (rng.integers(0, WIDTH * HEIGHT, number) << 3))


def read_out(keys: Longs, bounds: list[int], config: ReadoutConfig) -> tuple[Longs, int, int]:
    """Return the keys of all events read out, the number dropped, and the number that waits."""
    arbiter = Arbiter(width=WIDTH, height=HEIGHT, config=config, refractory_us=3)
    parts, dropped, waiting = [], 0, 0
    for a, b in pairwise(bounds):
        first, last = np.searchsorted(keys >> TIME_SHIFT, [a, b], side="right")
        found, stats = arbiter.read_out(keys[first:last] - (a << TIME_SHIFT), from_us=a, to_us=b)
        parts.append(found + (a << TIME_SHIFT))
        dropped, waiting = dropped + stats.dropped, stats.waiting
    return np.concatenate(parts), dropped, waiting


@pytest.mark.parametrize("rate_mev_s", [1.0, 4.5, 9.0, 20.0])
@pytest.mark.parametrize("kind", [ReadoutKind.ROW_ARBITER, ReadoutKind.ROUND_ROBIN])
def test_no_event_is_lost_or_read_before_its_time(kind: ReadoutKind, rate_mev_s: float) -> None:
    keys = offered(rate_mev_s)
    found, dropped, waiting = read_out(keys, [0, 7_000, 20_000], ReadoutConfig(kind=kind))
    assert found.size + dropped + waiting == keys.size
    assert np.all(np.diff(found) > 0)
    if rate_mev_s == 1.0:
        assert dropped == 0
    before, after = (_by_pixel(x) for x in (keys, found))
    place = np.searchsorted(before[0], after[0])
    nth = np.arange(after[0].size) - np.searchsorted(after[0], after[0])
    assert np.all(before[0][place + nth] == after[0])
    assert np.all(before[1][place + nth] <= after[1])


def _by_pixel(keys: Longs) -> tuple[Longs, Longs]:
    """Return pixels and times, sorted by pixel and then by time."""
    pixel, time = (keys >> 3) & PIXEL_MASK, keys >> TIME_SHIFT
    order = np.lexsort((time, pixel))
    return pixel[order], time[order]


@pytest.mark.parametrize("rate_mev_s", [4.5, 9.0])
def test_the_output_is_the_same_in_any_steps(rate_mev_s: float) -> None:
    keys = offered(rate_mev_s)
    whole, *rest = read_out(keys, [0, 20_000], ReadoutConfig())
    for bounds in ([0, 1, 2, 999, 20_000], [*range(0, 20_001, 100)]):
        parts, *of_parts = read_out(keys, bounds, ReadoutConfig())
        assert parts.tobytes() == whole.tobytes()
        assert of_parts == rest


def grants_of_a_crowd(config: ReadoutConfig) -> Longs:
    """Return the lines in the order of their grants if every pixel requests all the time.

    A word takes 1 µs, so that no time stamp has several lines.
    """
    arbiter = Arbiter(width=WIDTH, height=HEIGHT, config=config, refractory_us=0)
    pixels = np.arange(WIDTH * HEIGHT) << 3
    found, lines = [], []
    for step in range(4):
        keys = np.sort(
            np.concatenate([pixels | (t << TIME_SHIFT) for t in range(1, 400_000, 4000)])
        )
        out, _ = arbiter.read_out(keys, from_us=step * 400_000, to_us=(step + 1) * 400_000)
        found.append(out)
    for out in found:
        pixel = (out >> 3) & PIXEL_MASK
        line = pixel % WIDTH if config.lines is Lines.COLUMNS else pixel // WIDTH
        first = np.flatnonzero(np.diff(out >> TIME_SHIFT, prepend=-1))
        lines.append(line[first])
    return np.concatenate(lines)


@pytest.mark.parametrize("lines", list(Lines))
def test_in_a_crowd_every_line_gets_its_turn_and_blocks_are_read_whole(lines: Lines) -> None:
    number = WIDTH if lines is Lines.COLUMNS else HEIGHT
    order = grants_of_a_crowd(ReadoutConfig(limit_hz=1e6, lines=lines))
    assert order.size > 3 * number
    for line in range(number):
        turns = np.flatnonzero(order == line)
        assert turns.size >= 2
        assert np.diff(turns).max() <= 2 * number
    for size in (2, 4, 16, 64):
        block = order // size
        visits = np.split(block, np.flatnonzero(np.diff(block)) + 1)
        inner = [x for x in visits[1:-1] if (x[0] + 1) * size <= number]
        assert {x.size for x in inner} == {size}


@pytest.mark.parametrize("kind", [ReadoutKind.ROW_ARBITER, ReadoutKind.ROUND_ROBIN])
def test_the_tree_moves_both_ways_and_a_readout_in_turn_one_way(kind: ReadoutKind) -> None:
    order = grants_of_a_crowd(ReadoutConfig(limit_hz=1e6, kind=kind))
    forward = float(np.mean(np.diff(order) > 0))
    if kind is ReadoutKind.ROW_ARBITER:
        assert 0.4 < forward < 0.6
    else:
        assert forward > 0.99


def test_a_tie_has_no_preference() -> None:
    sides = [either(node, 1_000_000 * t) for node in range(1, 40) for t in range(500)]
    assert np.mean(sides) == pytest.approx(0.5, abs=0.02)


def flicker(frames: int) -> Iterator[tuple[int, np.ndarray]]:
    """Yield frames of random luminance that flicker together and overload the bus."""
    luminance = np.random.default_rng(1).uniform(20.0, 180.0, (48, 64))
    for k in range(frames):
        gain = 1.0 + 0.5 * np.sin(2.0 * np.pi * 0.1 * k)
        yield k * 1000, (luminance * gain).astype(np.float32)


def test_an_overloaded_sensor_gives_the_same_events_with_any_number_of_threads() -> None:
    config = replace(SensorConfig(width=64, height=48), readout=ReadoutConfig(limit_hz=3e6))
    outputs = [
        [sensor.step(t, frame) for t, frame in flicker(60)]
        for sensor in (EventSensor(config, seed=2, threads=n) for n in (1, 2, 3))
    ]
    events = [np.concatenate([o.events for o in of]).tobytes() for of in outputs]
    assert sum(o.readout.delayed for o in outputs[0]) > 10_000
    assert events[0] == events[1] == events[2]
