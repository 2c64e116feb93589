from collections.abc import Iterator
from dataclasses import asdict
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emulator import EventSensor, SensorConfig
from emulator.readout.arbiter import Arbiter
from emulator.readout.arbiter_tree import either
from emulator.readout.arbitration import PS_PER_US
from emulator.readout.config import UNLIMITED, Lines, ReadoutConfig, ReadoutKind
from emulator.readout.event_keys import TIME_SHIFT
from emulator.readout.stats import ReadoutStats
from flybench.events import check_events
from tests.emulator.stimuli import (
    HEIGHT,
    WIDTH,
    intervals_us,
    moving_texture,
    noise_free_config,
    noisy_config,
    run_sensor,
)

Keys = np.ndarray[Any, np.dtype[np.int64]]
Event = tuple[int, int]
"""Time [µs] and pixel."""


def keys_of(events: list[Event], from_us: int = 0) -> Keys:
    return np.sort(
        np.array([((t - from_us) << TIME_SHIFT) | (p << 3) for t, p in events], np.int64)
    )


def events_of(keys: Keys, from_us: int = 0) -> list[Event]:
    return [(from_us + (int(k) >> TIME_SHIFT), (int(k) >> 3) & (2**30 - 1)) for k in keys]


def run_arbiter(
    events: list[Event], bounds: list[int], **options: Any
) -> tuple[list[Event], list[ReadoutStats]]:
    refractory_us = options.pop("refractory_us")
    arbiter = Arbiter(
        width=WIDTH, height=HEIGHT, config=ReadoutConfig(**options), refractory_us=refractory_us
    )
    out: list[Event] = []
    readouts = []
    for a, b in pairwise(bounds):
        step = [event for event in events if a < event[0] <= b]
        keys, readout = arbiter.read_out(keys_of(step, a), from_us=a, to_us=b)
        stamped = events_of(keys, a)
        assert all(a < t <= b for t, _ in stamped)
        assert stamped == sorted(stamped)
        out += stamped
        readouts.append(readout)
    return out, readouts


class InTurn:
    """Grants the lines in their order."""

    def __init__(self) -> None:
        self.last = -1

    def request(self, line: int, at_ps: int) -> None:
        pass

    def rest(self) -> None:
        self.last = -1

    def choose(self, waiting: set[int], _now_ps: int) -> int:
        self.last = next((line for line in sorted(waiting) if line > self.last), min(waiting))
        return self.last


class Tree:
    """The tree of arbiters as a recursion: a visit to a node is a generator of lines."""

    def __init__(self, leaves: int) -> None:
        self.leaves = leaves
        self.since: dict[int, int] = {}
        self.waiting: set[int] = set()
        self.now_ps = 0
        self.rest()

    def request(self, line: int, at_ps: int) -> None:
        node = self.leaves + line
        while node > 0:
            self.since.setdefault(node, at_ps)
            node //= 2

    def rest(self) -> None:
        self.since.clear()
        self.grants = self.visit(1)

    def choose(self, waiting: set[int], now_ps: int) -> int:
        self.waiting, self.now_ps = waiting, now_ps
        line = next(self.grants, None)
        if line is None:
            self.grants = self.visit(1)
            line = next(self.grants)
        return line

    def waits(self, node: int) -> bool:
        if node >= self.leaves:
            return node - self.leaves in self.waiting
        return self.waits(2 * node) or self.waits(2 * node + 1)

    def visit(self, node: int) -> Iterator[int]:
        if node >= self.leaves:
            del self.since[node]
            yield node - self.leaves
            return
        left, right = 2 * node, 2 * node + 1
        sides = [side for side in (left, right) if self.waits(side)]
        if len(sides) == 2 and self.since[left] == self.since[right]:
            sides = sides if either(node, self.now_ps) == 0 else sides[::-1]
        first, *_ = sorted(sides, key=lambda side: self.since[side])
        yield from self.visit(first)
        if self.waits(first ^ 1):
            yield from self.visit(first ^ 1)
        del self.since[node]
        if self.waits(node):
            self.since[node] = self.now_ps


def reference(
    events: list[Event], config: ReadoutConfig, refractory_us: int
) -> tuple[list[Event], int]:
    """Run the arbiter in plain Python over a whole sequence, without steps."""
    word_ps = round(1e12 / config.limit_hz)
    arbiter = InTurn() if config.kind is ReadoutKind.ROUND_ROBIN else Tree(16)
    waiting: dict[int, dict[int, int]] = {}
    busy_until: dict[int, int] = {}
    queue = sorted(events)
    out: list[Event] = []
    bus, dropped = 0, 0
    while queue or waiting:
        if not waiting:
            arbiter.rest()
            bus = max(bus, queue[0][0] * PS_PER_US)
        while queue and queue[0][0] * PS_PER_US <= bus:
            t, pixel = queue.pop(0)
            line = pixel % WIDTH if config.lines is Lines.COLUMNS else pixel // WIDTH
            if t < busy_until.get(pixel, -1) or pixel in waiting.get(line, {}):
                dropped += 1
                continue
            if line not in waiting:
                arbiter.request(line, t * PS_PER_US)
            waiting.setdefault(line, {})[pixel] = t
        if not waiting:
            continue
        served = waiting.pop(arbiter.choose(set(waiting), bus))
        stamp = bus // PS_PER_US
        for pixel, since in served.items():
            out.append((stamp, pixel))
            if stamp > since:
                busy_until[pixel] = stamp + refractory_us
        bus += (config.line_words + len(served)) * word_ps
    return sorted(out), dropped


event_lists = st.lists(
    st.tuples(st.integers(1, 60), st.integers(0, WIDTH * HEIGHT - 1)), max_size=120, unique=True
)


readouts = st.builds(
    ReadoutConfig,
    kind=st.sampled_from([ReadoutKind.ROW_ARBITER, ReadoutKind.ROUND_ROBIN]),
    lines=st.sampled_from(list(Lines)),
    limit_hz=st.sampled_from([12e6, 2e6, 0.4e6]),
    line_words=st.sampled_from([0, 1, 2]),
)


@settings(max_examples=300, deadline=None)
@given(event_lists, readouts, st.sampled_from([0, 3, 20]))
def test_the_kernel_matches_the_reference(
    events: list[Event], config: ReadoutConfig, refractory_us: int
) -> None:
    expected, dropped = reference(events, config, refractory_us)
    options = {**asdict(config), "refractory_us": refractory_us}
    found, stats = run_arbiter(events, [0, 60, 10_000], **options)
    assert found == expected
    assert sum(r.dropped for r in stats) == dropped
    assert sum(r.offered for r in stats) == len(events)
    assert len(found) + dropped == len(events)
    assert stats[-1].waiting == 0


@settings(max_examples=150, deadline=None)
@given(
    event_lists,
    readouts,
    st.lists(st.integers(1, 199), max_size=8, unique=True),
    st.sampled_from([0, 7, 90]),
)
def test_steps_do_not_change_the_output(
    events: list[Event], config: ReadoutConfig, cuts: list[int], latency_us: int
) -> None:
    options = {**asdict(config), "latency_us": latency_us, "refractory_us": 5}
    whole, _ = run_arbiter(events, [0, 1000], **options)
    parts, _ = run_arbiter(events, [0, *sorted(cuts), 200, 1000], **options)
    assert parts == whole


def test_events_not_granted_in_their_step_are_read_in_a_later_one() -> None:
    burst = [(10, pixel) for pixel in range(100)]
    options = {"limit_hz": 1e6, "latency_us": 0, "refractory_us": 0}
    found, readouts = run_arbiter(burst, [0, 10, 60, 1000], **options)
    assert readouts[0].waiting == 100 - sum(t <= 10 for t, _ in found)
    assert readouts[0].waiting > readouts[1].waiting > readouts[2].waiting == 0
    assert max(r.delay_max_us for r in readouts) == max(t for t, _ in found) - 10
    columns = {t: {p % WIDTH for s, p in found if s == t} for t, _ in found}
    assert all(len(of_stamp) == 1 for of_stamp in columns.values())


def test_the_output_rate_is_limited_by_the_bus() -> None:
    """All columns request at all times; the 12 events of a column take 14 words."""
    rng = np.random.default_rng(1)
    times, pixels = rng.integers(1, 2001, 40_000), rng.integers(0, WIDTH * HEIGHT, 40_000)
    events = sorted(set(zip(times.tolist(), pixels.tolist(), strict=True)))
    found, readouts = run_arbiter(events, [0, 2000], limit_hz=2e6, latency_us=0, refractory_us=0)
    rate_hz = len(found) / 2000e-6
    assert 0.75 * 2e6 < rate_hz < 1.01 * 12 / 14 * 2e6
    assert readouts[0].dropped > 30_000


def test_latency_moves_every_stamp() -> None:
    events = [(t, 3 * t % 192) for t in range(1, 100, 7)]
    options = {"limit_hz": 12e6, "refractory_us": 0}
    prompt, _ = run_arbiter(events, [0, 50, 1000], latency_us=0, **options)
    late, _ = run_arbiter(events, [0, 50, 1000], latency_us=33, **options)
    assert late == [(t + 33, p) for t, p in prompt]


def test_at_low_rates_no_event_is_lost_or_delayed() -> None:
    free = run_sensor(noisy_config(readout=UNLIMITED), moving_texture(60))
    real = run_sensor(noisy_config(), moving_texture(60))
    assert free[0].size > 500
    assert real[0].tobytes() == free[0].tobytes()
    assert real[1].tobytes() == free[1].tobytes()


@pytest.mark.parametrize("limit_hz", [3e4, 3e5])
def test_at_high_rates_no_event_is_unaccounted_for(limit_hz: float) -> None:
    config = noisy_config(readout=ReadoutConfig(limit_hz=limit_hz), refractory_us=200)
    sensor = EventSensor(config, seed=1)
    outputs = [sensor.step(t, frame) for t, frame in moving_texture(80)]
    events = np.concatenate([o.events for o in outputs])
    check_events(events, width=WIDTH, height=HEIGHT)
    assert intervals_us(events).min() >= 200
    offered = sum(o.readout.offered for o in outputs)
    dropped = sum(o.readout.dropped for o in outputs)
    assert events.size + dropped + outputs[-1].readout.waiting == offered
    assert sum(o.readout.delayed for o in outputs) > 100
    for before, output in pairwise(range(0, 80_000, 1000)):
        step = outputs[output // 1000].events["t"]
        assert np.all((step > before) & (step <= output))


def test_an_ideal_sensor_has_no_arbiter() -> None:
    config = SensorConfig.ideal(width=WIDTH, height=HEIGHT)
    sensor = EventSensor(config, seed=1)
    outputs = [sensor.step(t, frame) for t, frame in moving_texture(40)]
    assert sum(o.readout.offered for o in outputs) == sum(o.events.size for o in outputs) > 100
    assert all(o.readout.delayed == o.readout.dropped == 0 for o in outputs)


def test_without_events_all_counts_are_zero() -> None:
    sensor = EventSensor(noise_free_config(), seed=1)
    frame = next(moving_texture(1))[1]
    sensor.step(0, frame)
    assert sensor.step(1000, frame).readout == ReadoutStats()
