from collections import defaultdict
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emulator import EventSensor, SensorConfig
from emulator.readout.arbiter import Arbiter
from emulator.readout.arbitration import PS_PER_US
from emulator.readout.config import UNLIMITED, ReadoutConfig
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
    arbiter = Arbiter(width=WIDTH, height=HEIGHT, **options)
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


def reference(events: list[Event], *, word_ps: int, refractory_us: int) -> tuple[list[Event], int]:
    """Run the arbiter in plain Python over a whole sequence, without steps."""
    waiting: dict[int, dict[int, int]] = defaultdict(dict)
    busy_until: dict[int, int] = {}
    queue = sorted(events)
    out: list[Event] = []
    bus, last, dropped = 0, -1, 0
    while queue or any(waiting.values()):
        if not any(waiting.values()):
            last = -1
            bus = max(bus, queue[0][0] * PS_PER_US)
        while queue and queue[0][0] * PS_PER_US <= bus:
            t, pixel = queue.pop(0)
            held = t < busy_until.get(pixel, -1)
            if held or pixel in waiting[pixel // WIDTH]:
                dropped += 1
            else:
                waiting[pixel // WIDTH][pixel] = t
        rows = sorted(row for row, pixels in waiting.items() if pixels)
        if not rows:
            continue
        row = next((row for row in rows if row > last), rows[0])
        stamp = bus // PS_PER_US
        for pixel, since in waiting[row].items():
            out.append((stamp, pixel))
            if stamp > since:
                busy_until[pixel] = stamp + refractory_us
        bus += (1 + len(waiting[row])) * word_ps
        last = row
        waiting[row] = {}
    return sorted(out), dropped


event_lists = st.lists(
    st.tuples(st.integers(1, 60), st.integers(0, WIDTH * HEIGHT - 1)), max_size=120, unique=True
)


@settings(max_examples=150, deadline=None)
@given(event_lists, st.sampled_from([12e6, 2e6, 0.4e6]), st.sampled_from([0, 3, 20]))
def test_the_kernel_matches_the_reference(
    events: list[Event], limit_hz: float, refractory_us: int
) -> None:
    word_ps = round(1e12 / limit_hz)
    expected, dropped = reference(events, word_ps=word_ps, refractory_us=refractory_us)
    options = {"limit_hz": limit_hz, "latency_us": 0, "refractory_us": refractory_us}
    found, readouts = run_arbiter(events, [0, 60, 10_000], **options)
    assert found == expected
    assert sum(r.dropped for r in readouts) == dropped
    assert sum(r.offered for r in readouts) == len(events)
    assert len(found) + dropped == len(events)
    assert readouts[-1].waiting == 0


@settings(max_examples=60, deadline=None)
@given(
    event_lists, st.lists(st.integers(1, 199), max_size=8, unique=True), st.sampled_from([0, 7, 90])
)
def test_steps_do_not_change_the_output(
    events: list[Event], cuts: list[int], latency_us: int
) -> None:
    options = {"limit_hz": 1e6, "latency_us": latency_us, "refractory_us": 5}
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
    rows = {t: {p // WIDTH for s, p in found if s == t} for t, _ in found}
    assert all(len(of_stamp) == 1 for of_stamp in rows.values())


def test_the_output_rate_is_limited_by_the_bus() -> None:
    """All rows request at all times; the 16 events of a row take 17 words."""
    rng = np.random.default_rng(1)
    times, pixels = rng.integers(1, 2001, 40_000), rng.integers(0, WIDTH * HEIGHT, 40_000)
    events = sorted(set(zip(times.tolist(), pixels.tolist(), strict=True)))
    found, readouts = run_arbiter(events, [0, 2000], limit_hz=2e6, latency_us=0, refractory_us=0)
    rate_hz = len(found) / 2000e-6
    assert 0.85 * 2e6 < rate_hz < 1.01 * 16 / 17 * 2e6
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
