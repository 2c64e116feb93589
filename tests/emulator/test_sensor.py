import hashlib
import math
import subprocess
import sys
import tracemalloc
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emulator import Davis346, EventSensor, FrameError, SensorConfig, SensorConfigError
from emulator.readout.config import UNLIMITED
from flybench.events import EVENT_DTYPE, Cause, check_events
from flybench.memory import MemoryBudgetError
from tests.emulator.stimuli import (
    HEIGHT,
    WIDTH,
    intervals_us,
    log_ramp,
    luminance_for_lux,
    moving_texture,
    noise_free_config,
    noisy_config,
    run_sensor,
    uniform_frame,
)


@pytest.mark.parametrize("level", [0.0, 0.01, 0.3, 10.0, 500.0, 20_000.0])
def test_a_static_scene_without_noise_gives_no_event(level: float) -> None:
    config = SensorConfig.noise_free(width=WIDTH, height=HEIGHT)
    config = replace(config, aps=replace(config.aps, period_min_us=10_000_000))
    scene = level * np.random.default_rng(1).uniform(0.0, 2.0, (HEIGHT, WIDTH)).astype(np.float32)
    samples = [(0, scene)] + [(t, scene) for t in (100, 1100, 21_100, 10**6, 10**9)]
    assert run_sensor(config, samples)[0].size == 0


def test_output_depends_on_the_seed_and_only_on_it() -> None:
    first, second, other = (
        run_sensor(noisy_config(), moving_texture(60), seed=seed) for seed in (7, 7, 8)
    )
    assert first[0].tobytes() == second[0].tobytes()
    assert first[1].tobytes() == second[1].tobytes()
    assert first[0].size > 500
    assert first[0].tobytes() != other[0].tobytes()


def test_another_process_gives_the_same_events() -> None:
    script = (
        "import hashlib; from tests.emulator.stimuli import *;"
        "events, causes = run_sensor(noisy_config(), moving_texture(60, level=0.5), seed=7);"
        "print(hashlib.sha256(events.tobytes() + causes.tobytes()).hexdigest())"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    events, causes = run_sensor(noisy_config(), moving_texture(60, level=0.5), seed=7)
    here = hashlib.sha256(events.tobytes() + causes.tobytes()).hexdigest()
    assert done.stdout.strip() == here
    assert events.size > 100


@settings(max_examples=10, deadline=None)
@given(st.lists(st.integers(1, 29), max_size=5))
def test_cutting_a_stream_changes_no_event(cuts: list[int]) -> None:
    samples = list(moving_texture(30))
    whole, _ = run_sensor(noisy_config(), samples, seed=2)
    sensor = EventSensor(noisy_config(), seed=2)
    bounds = [0, *sorted(cuts), len(samples)]
    parts = [o.events for a, b in pairwise(bounds) for o in sensor.stream(samples[a:b])]
    assert np.concatenate(parts).tobytes() == whole.tobytes()


def test_a_stream_that_starts_after_ten_hours_has_the_same_events() -> None:
    shift = 36_000_000_000
    early, _ = run_sensor(noisy_config(), moving_texture(30), seed=2)
    late, _ = run_sensor(noisy_config(), ((t + shift, f) for t, f in moving_texture(30)), seed=2)
    assert np.array_equal(late["t"] - shift, early["t"])
    assert np.array_equal(late["x"], early["x"])
    assert late["t"].dtype == np.int64


def test_events_are_sorted_final_and_within_their_step() -> None:
    sensor, last = EventSensor(noisy_config(), seed=3), -1
    for t_us, frame in moving_texture(40, step_us=700):
        output = sensor.step(t_us, frame)
        events = output.events
        assert events.dtype == EVENT_DTYPE
        assert output.causes.dtype == np.uint8
        assert output.causes.shape == events.shape
        check_events(events, width=WIDTH, height=HEIGHT)
        assert np.all((events["t"] > last) & (events["t"] <= t_us))
        pixel = events["y"].astype(int) * WIDTH + events["x"]
        assert np.all(np.diff(events["t"] * 10_000 + pixel) > 0)
        last = t_us


@pytest.mark.parametrize(("rate", "theta", "on"), [(40.0, 0.28, True), (-40.0, 0.35, False)])
def test_crossings_of_a_log_ramp_match_the_closed_form(rate: float, theta: float, on: bool) -> None:
    config = SensorConfig.ideal(width=2, height=2)
    samples = log_ramp(config, start=300.0, rate_per_s=rate, times_us=range(0, 100_001, 1000))
    events, causes = run_sensor(config, samples)
    mine = events[(events["x"] == 1) & (events["y"] == 1)]
    period_us = theta / abs(rate) * 1e6
    expected = period_us * np.arange(1, math.floor(100_000 / period_us) + 1)
    assert np.abs(mine["t"] - expected).max() <= 2
    assert np.all(mine["p"] == on)
    assert np.all(causes == Cause.SIGNAL)


def test_a_low_pass_delays_a_ramp_by_its_time_constant() -> None:
    config = noise_free_config(refractory_us=0, readout=UNLIMITED)
    samples = log_ramp(config, start=300.0, rate_per_s=40.0, times_us=range(0, 100_001, 1000))
    events, _ = run_sensor(config, samples)
    mine = events["t"][(events["x"] == 1) & (events["y"] == 1)]
    tau_us = 1e6 / (2 * math.pi * config.bandwidth_limit_hz)
    expected = 0.18 / 40.0 * 1e6 * np.arange(1, mine.size + 1) + tau_us
    assert mine.size >= 21
    assert np.abs(mine - expected).max() <= 2


@pytest.mark.parametrize("start_lux", [0.5, 300.0])
def test_a_ramp_gives_the_same_events_at_any_step(start_lux: float) -> None:
    """This includes dim light, where the cutoff changes along the ramp."""
    config = noise_free_config(readout=UNLIMITED)

    def times(step_us: int) -> np.ndarray:
        samples = log_ramp(
            config, start=start_lux, rate_per_s=30.0, times_us=range(0, 80_001, step_us)
        )
        events, _ = run_sensor(config, samples)
        assert events["p"].all()
        return np.asarray(events["t"][(events["x"] == 1) & (events["y"] == 1)])

    fine, coarse, uneven = times(500), times(1000), times(100)
    assert fine.size == coarse.size == uneven.size >= 8
    assert np.abs(fine - coarse).max() <= 2
    assert np.abs(fine - uneven).max() <= 2


@pytest.mark.parametrize("step_us", [200, 5000])
def test_the_response_to_a_luminance_step_is_exponential(step_us: int) -> None:
    """Threshold k is crossed when 1 − exp(−t/τ) reaches k·θ divided by the height of the step."""
    config = noise_free_config(refractory_us=0, dark_lux=1e-6, readout=UNLIMITED)
    height, lux = 1.0, 1.0
    low, high = (uniform_frame(luminance_for_lux(e, config), config) for e in (lux / math.e, lux))
    samples = [(0, low), (1, high), *((1 + t, high) for t in range(step_us, 20_001, step_us))]
    events, _ = run_sensor(config, samples)
    mine = events["t"][(events["x"] == 0) & (events["y"] == 0)]
    tau_us = 1e6 / (2 * math.pi * config.bandwidth_hz_per_lux * lux)
    shares = config.theta_on * np.arange(1, 6) / height
    assert mine.size == 5
    assert np.abs(mine - (1 - tau_us * np.log(1 - shares))).max() <= 2


def test_changes_during_the_refractory_period_are_lost() -> None:
    rate, refractory_us = 1000.0, 500
    config = replace(SensorConfig.ideal(width=2, height=2), refractory_us=refractory_us)
    samples = log_ramp(config, start=1.0, rate_per_s=rate, times_us=range(0, 10_001, 250))
    events, _ = run_sensor(config, samples)
    period_us = config.theta_on / rate * 1e6 + refractory_us
    assert np.all(np.abs(intervals_us(events) - period_us) <= 1)
    assert events.size == 4 * math.floor((10_000 + refractory_us) / period_us)


def test_no_two_events_of_a_pixel_are_closer_than_the_refractory_period() -> None:
    config = noisy_config(refractory_us=300, noise_sigma=0.2)
    events, _ = run_sensor(config, moving_texture(100, level=0.5))
    gaps = intervals_us(events)
    assert gaps.size > 1000
    assert gaps.min() >= 300


def test_signal_events_do_not_concentrate_at_sample_times() -> None:
    events, _ = run_sensor(noisy_config(), moving_texture(400))
    counts = np.histogram((events["t"] - 1) % 1000, 10, (0, 1000))[0]
    assert events.size > 5000
    assert np.abs(counts / counts.mean() - 1).max() < 0.25
    assert np.mean(events["t"] % 1000 == 0) < 0.01


def test_the_cause_is_signal_where_signal_outweighs_leak() -> None:
    config = noise_free_config(leak_hz=0.1)
    samples = log_ramp(config, start=100.0, rate_per_s=5.0, times_us=range(0, 200_001, 1000))
    _, causes = run_sensor(config, samples)
    assert np.mean(causes == Cause.SIGNAL) > 0.85


def test_mismatch_is_reproducible() -> None:
    config = SensorConfig.noise_free(width=WIDTH, height=HEIGHT)
    samples = list(log_ramp(config, start=100.0, rate_per_s=10.0, times_us=range(0, 60_001, 1000)))
    events, _ = run_sensor(config, samples)
    pixel = events["y"].astype(int) * WIDTH + events["x"]
    _, first = np.unique(pixel, return_index=True)
    thetas = events["t"][first] * 1e-6 * 10.0
    assert thetas.std() == pytest.approx(config.theta_mismatch, rel=0.25)
    assert run_sensor(config, samples)[0].tobytes() == events.tobytes()


def test_a_step_may_return_many_events() -> None:
    config = replace(SensorConfig.ideal(width=64, height=64), theta_on=0.01)
    samples = [(0, uniform_frame(1.0, config)), (20_000, uniform_frame(1000.0, config))]
    events, _ = run_sensor(config, samples)
    rise = math.log((1000 + 0.01 / 0.36) / (1 + 0.01 / 0.36))
    assert events.size == pytest.approx(4096 * rise / 0.01, rel=0.005)
    check_events(events, width=64, height=64)


def test_zero_luminance_is_valid() -> None:
    config = noise_free_config()
    samples = [
        (0, uniform_frame(0.0, config)),
        (1000, uniform_frame(1.0, config)),
        (200_000, uniform_frame(0.0, config)),
    ]
    events, _ = run_sensor(config, [*samples, (5_000_000, uniform_frame(0.0, config))])
    assert events["p"].any()
    assert not events["p"].all()


def mean_rate(step_us: int, level: float) -> tuple[float, float, float]:
    """Return the numbers of ON and OFF events, and their mean interval, of a smooth scene."""
    config = noisy_config(width=48, height=36)
    x, y = np.meshgrid(np.arange(48), np.arange(36))

    def frame(t_us: int) -> np.ndarray:
        wave = np.sin(0.35 * x + 0.2 * y - 0.35 * 0.4e-3 * t_us)
        return (level * np.exp(0.9 * wave)).astype(np.float32)

    times = range(0, 200_001, step_us)
    events, _ = run_sensor(config, ((t, frame(t)) for t in times))
    return events["p"].sum(), (~events["p"]).sum(), intervals_us(events).mean()


@pytest.mark.parametrize("level", [0.5, 300.0])
def test_halving_the_step_changes_no_statistics(level: float) -> None:
    """At 0.4 and 0.2 px per step; at night, where noise dominates, and by day."""
    coarse, fine = mean_rate(1000, level), mean_rate(500, level)
    assert min(fine[:2]) > 1000
    for count, other in zip(coarse[:2], fine[:2], strict=True):
        assert abs(count - other) < 0.01 * other + 3.0 * math.sqrt(other) * 0.5
    assert coarse[2] == pytest.approx(fine[2], rel=0.03)


@pytest.mark.parametrize("level", [0.3, 100.0])
def test_events_fall_on_sample_times_only_by_chance(level: float) -> None:
    events, _ = run_sensor(noisy_config(), moving_texture(2000, level=level))
    on_frame = np.sum(events["t"] % 1000 == 0)
    by_chance = events.size / 1000
    assert events.size > 5000
    assert on_frame - by_chance < 0.01 * events.size
    assert on_frame < by_chance + 5.0 * math.sqrt(by_chance)


def test_memory_does_not_grow_with_time() -> None:
    """After ten minutes of a stream it equals that after the first seconds."""
    sensor, sizes = EventSensor(noisy_config(), seed=1), []
    samples = [frame for _, frame in moving_texture(8, level=0.5)]
    for k in range(6000):
        sensor.step(k * 100_000, samples[k % 8])
        if k in (300, 5999):
            arrays = [*sensor._state, *sensor._active, *sensor._keys]  # type: ignore[misc]
            arrays += [*sensor._readout._queue, sensor._readout._granted]  # type: ignore[union-attr]
            sizes.append(sum(array.nbytes for array in arrays))
    assert sizes[0] == sizes[1]


def test_a_step_changes_41_bytes_a_pixel() -> None:
    """This counts everything that a step changes, frames and readout included, but no mismatch."""
    sensor = EventSensor(SensorConfig(), seed=1)
    for t_us, luminance in ((0, 1.0), (1000, 2.0)):
        sensor.step(t_us, np.full((260, 346), luminance, np.float32))
    assert sensor._state is not None
    arrays = [*sensor._state, sensor._aps._correction, sensor._readout._queue.waits]  # type: ignore[union-attr]
    assert sum(array.nbytes for array in arrays) / (346 * 260) - 20 < 41.1


def test_a_sensor_takes_the_memory_that_the_readme_states() -> None:
    """71 bytes per pixel at 346×260, mismatch and lists of events included."""
    still = np.full((260, 346), 100.0, np.float32)
    EventSensor(SensorConfig(width=16, height=16), seed=1).step(0, still[:16, :16])
    tracemalloc.start()
    try:
        sensor = EventSensor(SensorConfig(), seed=1)
        for t_us in range(0, 20_000, 1000):
            sensor.step(t_us, still)
        held, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert 66.0 < held / still.size < 72.0


def test_leak_and_dark_current_double_every_7_k() -> None:
    warm, cool = noisy_config(temperature_c=46.0), noisy_config()
    assert warm.warm_leak_hz == pytest.approx(8.0 * cool.warm_leak_hz)
    assert warm.warm_dark_lux == pytest.approx(8.0 * cool.warm_dark_lux)
    bare = noise_free_config(leak_hz=1.0)
    counts = []
    for config in (bare, replace(bare, temperature_c=32.0)):
        frame = uniform_frame(1.0, config)
        samples = ((t, frame) for t in range(0, 5_000_001, 50_000))
        counts.append(run_sensor(config, samples)[0].size)
    assert counts[1] == pytest.approx(2 * counts[0], rel=0.02)


def test_heat_reduces_the_response_in_the_dark() -> None:
    """Dark current adds to the photocurrent, so that its relative changes become smaller."""
    counts = []
    for celsius in (25.0, 60.0):
        config = noise_free_config(temperature_c=celsius)
        low, high = (uniform_frame(luminance_for_lux(lux, config), config) for lux in (0.05, 0.5))
        events, _ = run_sensor(config, [(0, low), (1000, high), (2_000_000, high)])
        counts.append(events.size)
    assert counts[0] > 1.5 * counts[1] > 0


def test_dead_pixels_are_silent_and_crazy_ones_fire_both_ways() -> None:
    config = noisy_config(
        dead_fraction=0.3, crazy_fraction=0.3, hot_fraction=0.0, crazy_hz_min=200.0, refractory_us=3
    )
    events, causes = run_sensor(config, moving_texture(1000, level=30.0))
    pixel = events["y"].astype(int) * WIDTH + events["x"]
    alive = np.unique(pixel).size / (WIDTH * HEIGHT)
    assert alive == pytest.approx(0.7, abs=0.1)
    crazy = events[causes == Cause.HOT]
    assert np.unique(pixel[causes == Cause.HOT]).size / (WIDTH * HEIGHT) == pytest.approx(
        0.21, abs=0.08
    )
    assert crazy["p"].mean() == pytest.approx(0.5, abs=0.03)
    assert crazy.size / np.unique(pixel[causes == Cause.HOT]).size == pytest.approx(600, rel=0.15)


@pytest.mark.parametrize("latency_us", [7, 2500])
def test_latency_delays_every_event_of_an_unlimited_bus(latency_us: int) -> None:
    prompt = noisy_config(readout=UNLIMITED)
    late = replace(prompt, readout=replace(UNLIMITED, latency_us=latency_us))
    samples = [(t, uniform_frame(1.0 + t / 5000, prompt)) for t in range(0, 40_000, 1000)]
    expected, _ = run_sensor(prompt, samples, seed=4)
    outputs = list(EventSensor(late, seed=4).stream(samples))
    found = np.concatenate([output.events for output in outputs])
    expected["t"] += latency_us
    assert np.array_equal(found, expected[expected["t"] <= 39_000])
    assert outputs[-1].readout.waiting == np.count_nonzero(expected["t"] > 39_000)
    assert max(output.readout.delay_max_us for output in outputs) == latency_us


def test_a_refused_step_with_too_many_frames_changes_nothing() -> None:
    config = noisy_config()
    frame = uniform_frame(5.0, config)
    sensor, other = EventSensor(config, seed=3), EventSensor(config, seed=3)
    for each in (sensor, other):
        each.step(0, frame)
    with pytest.raises(FrameError, match=r"the step is 25000001 µs long.*every 25000 µs.*shorter"):
        sensor.step(25_000_001, 2.0 * frame)
    after, expected = sensor.step(1_000_000, frame), other.step(1_000_000, frame)
    assert np.array_equal(after.events, expected.events)
    assert [f.end_us for f in after.aps_frames] == [f.end_us for f in expected.aps_frames]


@pytest.mark.parametrize("threads", [0, 65, 1.0, True])
def test_an_invalid_number_of_threads_is_refused(threads: Any) -> None:
    with pytest.raises(SensorConfigError, match="Allowed is a whole number from 1 to 64"):
        EventSensor(noisy_config(), seed=1, threads=threads)


def test_the_number_of_threads_may_be_a_numpy_integer() -> None:
    config = noisy_config()
    samples = [(t, uniform_frame(1.0 + t / 5000, config)) for t in range(0, 5000, 1000)]
    one, _ = run_sensor(config, samples, seed=4)
    two, _ = run_sensor(config, samples, seed=4, threads=np.int64(2))  # type: ignore[arg-type]
    assert np.array_equal(one, two)


def test_the_davis346_is_the_sensor_with_the_default_configuration() -> None:
    sensor = Davis346(seed=1)
    assert isinstance(sensor, EventSensor)
    assert sensor.config == SensorConfig()
    assert Davis346(noisy_config(), seed=1).config == noisy_config()


def test_a_huge_sensor_is_refused() -> None:
    with pytest.raises(MemoryBudgetError, match="A sensor of 30000×30000 px needs 135 GB"):
        EventSensor(SensorConfig(width=30_000, height=30_000), seed=0)


def test_too_many_events_in_a_step_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flybench.memory._counted", {})
    monkeypatch.setenv("FLYBENCH_MEMORY_GB", "0.01")
    sensor = EventSensor(replace(SensorConfig.ideal(width=64, height=64), theta_on=0.01), seed=0)
    sensor.step(0, np.full((64, 64), 1e-3, np.float32))
    with pytest.raises(MemoryBudgetError, match="The step from 0 to 1000 µs gives"):
        sensor.step(1000, np.full((64, 64), 1e6, np.float32))


def test_too_many_frames_in_a_step_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flybench.memory._counted", {})
    monkeypatch.setenv("FLYBENCH_MEMORY_GB", "0.01")
    sensor = EventSensor(SensorConfig.noise_free(width=100, height=100), seed=0)
    scene = np.full((100, 100), 100.0, np.float32)
    sensor.step(0, scene)
    with pytest.raises(MemoryBudgetError, match=r"with up to 801 APS frames needs 0\.016"):
        sensor.step(20_000_000, scene)
    assert sensor.step(1_000_000, scene).aps_frames
