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

from emulator import Davis346, FrameError, SensorConfig, SensorConfigError
from flybench.events import EVENT_DTYPE, Cause, check_events
from tests.emulator.scenes import (
    HEIGHT,
    WIDTH,
    flat,
    gaps_us,
    log_ramp,
    luminance_for,
    moving_texture,
    noisy,
    quiet,
    run,
)


@pytest.mark.parametrize("level", [0.0, 0.01, 0.3, 10.0, 500.0, 20_000.0])
def test_a_static_scene_without_noise_gives_no_event(level: float) -> None:
    config = SensorConfig.noise_free(width=WIDTH, height=HEIGHT)
    config = replace(config, aps=replace(config.aps, period_min_us=10_000_000))
    scene = level * np.random.default_rng(1).uniform(0.0, 2.0, (HEIGHT, WIDTH)).astype(np.float32)
    samples = [(0, scene)] + [(t, scene) for t in (100, 1100, 21_100, 10**6, 10**9)]
    assert run(Davis346(config, seed=1), samples)[0].size == 0


def test_same_seed_same_output_and_another_seed_another() -> None:
    first, second, other = (
        run(Davis346(noisy(), seed=seed), moving_texture(60)) for seed in (7, 7, 8)
    )
    assert first[0].tobytes() == second[0].tobytes()
    assert first[1].tobytes() == second[1].tobytes()
    assert first[0].size > 500
    assert first[0].tobytes() != other[0].tobytes()


def test_another_process_gives_the_same_events() -> None:
    script = (
        "import hashlib; from tests.emulator.scenes import *;"
        "events, causes = run(Davis346(noisy(), seed=7), moving_texture(60, level=0.5));"
        "print(hashlib.sha256(events.tobytes() + causes.tobytes()).hexdigest())"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    events, causes = run(Davis346(noisy(), seed=7), moving_texture(60, level=0.5))
    here = hashlib.sha256(events.tobytes() + causes.tobytes()).hexdigest()
    assert done.stdout.strip() == here
    assert events.size > 100


@settings(max_examples=10, deadline=None)
@given(st.lists(st.integers(1, 29), max_size=5))
def test_however_the_stream_is_cut(cuts: list[int]) -> None:
    samples = list(moving_texture(30))
    whole, _ = run(Davis346(noisy(), seed=2), samples)
    sensor = Davis346(noisy(), seed=2)
    bounds = [0, *sorted(cuts), len(samples)]
    parts = [o.events for a, b in pairwise(bounds) for o in sensor.stream(samples[a:b])]
    assert np.concatenate(parts).tobytes() == whole.tobytes()


def test_a_stream_that_starts_after_ten_hours_is_as_exact() -> None:
    shift = 36_000_000_000
    early, _ = run(Davis346(noisy(), seed=2), moving_texture(30))
    late, _ = run(Davis346(noisy(), seed=2), ((t + shift, f) for t, f in moving_texture(30)))
    assert np.array_equal(late["t"] - shift, early["t"])
    assert np.array_equal(late["x"], early["x"])
    assert late["t"].dtype == np.int64


def test_events_are_sorted_final_and_within_their_step() -> None:
    sensor, last = Davis346(noisy(), seed=3), -1
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


@pytest.mark.parametrize(("rate", "theta", "on"), [(40.0, 0.18, True), (-40.0, 0.22, False)])
def test_crossings_of_a_log_ramp_are_those_of_the_closed_form(
    rate: float, theta: float, on: bool
) -> None:
    config = SensorConfig.ideal(width=2, height=2)
    samples = log_ramp(config, start=300.0, rate_per_s=rate, times_us=range(0, 100_001, 1000))
    events, causes = run(Davis346(config, seed=1), samples)
    mine = events[(events["x"] == 1) & (events["y"] == 1)]
    period_us = theta / abs(rate) * 1e6
    expected = period_us * np.arange(1, math.floor(100_000 / period_us) + 1)
    assert np.abs(mine["t"] - expected).max() <= 2
    assert np.all(mine["p"] == on)
    assert np.all(causes == Cause.SIGNAL)


def test_a_low_pass_delays_a_ramp_by_its_time_constant() -> None:
    config = quiet(refractory_us=0)
    samples = log_ramp(config, start=300.0, rate_per_s=40.0, times_us=range(0, 100_001, 1000))
    events, _ = run(Davis346(config, seed=1), samples)
    mine = events["t"][(events["x"] == 1) & (events["y"] == 1)]
    tau_us = 1e6 / (2 * math.pi * config.bandwidth_limit_hz)
    expected = 0.18 / 40.0 * 1e6 * np.arange(1, mine.size + 1) + tau_us
    assert mine.size >= 21
    assert np.abs(mine - expected).max() <= 2


@pytest.mark.parametrize("start_lux", [0.5, 300.0])
def test_a_ramp_gives_the_same_events_at_any_step(start_lux: float) -> None:
    """In dim light too, where the cutoff moves with the ramp."""
    config = quiet()

    def times(step_us: int) -> np.ndarray:
        samples = log_ramp(
            config, start=start_lux, rate_per_s=30.0, times_us=range(0, 80_001, step_us)
        )
        events, _ = run(Davis346(config, seed=1), samples)
        assert events["p"].all()
        return np.asarray(events["t"][(events["x"] == 1) & (events["y"] == 1)])

    fine, coarse, uneven = times(500), times(1000), times(100)
    assert fine.size == coarse.size == uneven.size >= 8
    assert np.abs(fine - coarse).max() <= 2
    assert np.abs(fine - uneven).max() <= 2


@pytest.mark.parametrize("step_us", [200, 5000])
def test_a_step_of_light_is_followed_by_an_exponential(step_us: int) -> None:
    """Threshold k is crossed when 1 − exp(−t/τ) reaches k·θ over the step's height."""
    config = quiet(refractory_us=0, dark_lux=1e-6)
    height, lux = 1.0, 1.0
    low, high = (flat(luminance_for(e, config), config) for e in (lux / math.e, lux))
    samples = [(0, low), (1, high), *((1 + t, high) for t in range(step_us, 20_001, step_us))]
    events, _ = run(Davis346(config, seed=1), samples)
    mine = events["t"][(events["x"] == 0) & (events["y"] == 0)]
    tau_us = 1e6 / (2 * math.pi * config.bandwidth_hz_per_lux * lux)
    shares = config.theta_on * np.arange(1, 6) / height
    assert mine.size == 5
    assert np.abs(mine - (1 - tau_us * np.log(1 - shares))).max() <= 2


def test_refractory_period_is_kept_and_what_changes_meanwhile_is_lost() -> None:
    rate, refractory_us = 1000.0, 500
    config = replace(SensorConfig.ideal(width=2, height=2), refractory_us=refractory_us)
    samples = log_ramp(config, start=1.0, rate_per_s=rate, times_us=range(0, 10_001, 250))
    events, _ = run(Davis346(config, seed=1), samples)
    period_us = config.theta_on / rate * 1e6 + refractory_us
    assert np.all(np.abs(gaps_us(events) - period_us) <= 1)
    assert events.size == 4 * math.floor((10_000 + refractory_us) / period_us)


def test_no_two_events_of_a_pixel_are_closer_than_the_refractory_period() -> None:
    config = noisy(refractory_us=300, shot_noise_scale=20.0)
    events, _ = run(Davis346(config, seed=1), moving_texture(100, level=0.5))
    gaps = gaps_us(events)
    assert gaps.size > 1000
    assert gaps.min() >= 300


def test_signal_events_are_not_heaped_on_frame_times() -> None:
    events, _ = run(Davis346(noisy(), seed=1), moving_texture(400))
    counts = np.histogram((events["t"] - 1) % 1000, 10, (0, 1000))[0]
    assert events.size > 5000
    assert np.abs(counts / counts.mean() - 1).max() < 0.25
    assert np.mean(events["t"] % 1000 == 0) < 0.01


def test_signal_outweighs_leak_in_the_cause() -> None:
    config = quiet(leak_hz=0.1)
    samples = log_ramp(config, start=100.0, rate_per_s=5.0, times_us=range(0, 200_001, 1000))
    _, causes = run(Davis346(config, seed=1), samples)
    assert np.mean(causes == Cause.SIGNAL) > 0.85


def test_pixels_differ_by_mismatch_and_always_in_the_same_way() -> None:
    config = SensorConfig.noise_free(width=WIDTH, height=HEIGHT)
    samples = list(log_ramp(config, start=100.0, rate_per_s=10.0, times_us=range(0, 60_001, 1000)))
    events, _ = run(Davis346(config, seed=1), samples)
    pixel = events["y"].astype(int) * WIDTH + events["x"]
    _, first = np.unique(pixel, return_index=True)
    thetas = events["t"][first] * 1e-6 * 10.0
    assert thetas.std() == pytest.approx(config.theta_mismatch, rel=0.25)
    assert run(Davis346(config, seed=1), samples)[0].tobytes() == events.tobytes()


def test_many_events_in_one_step_all_come_out() -> None:
    config = replace(SensorConfig.ideal(width=64, height=64), theta_on=0.01)
    samples = [(0, flat(1.0, config)), (20_000, flat(1000.0, config))]
    events, _ = run(Davis346(config, seed=1), samples)
    rise = math.log((1000 + 0.01 / 0.36) / (1 + 0.01 / 0.36))
    assert events.size == pytest.approx(4096 * rise / 0.01, rel=0.005)
    check_events(events, width=64, height=64)


def test_darkness_is_light_too() -> None:
    config = quiet()
    samples = [(0, flat(0.0, config)), (1000, flat(1.0, config)), (200_000, flat(0.0, config))]
    events, _ = run(Davis346(config, seed=1), [*samples, (5_000_000, flat(0.0, config))])
    assert events["p"].any()
    assert not events["p"].all()


def mean_rate(step_us: int, level: float) -> tuple[float, float, float]:
    """ON and OFF events, and their mean interval, of a smooth scene sampled every `step_us`."""
    config = noisy(width=48, height=36)
    x, y = np.meshgrid(np.arange(48), np.arange(36))

    def frame(t_us: int) -> np.ndarray:
        wave = np.sin(0.35 * x + 0.2 * y - 0.35 * 0.4e-3 * t_us)
        return (level * np.exp(0.9 * wave)).astype(np.float32)

    times = range(0, 200_001, step_us)
    events, _ = run(Davis346(config, seed=1), ((t, frame(t)) for t in times))
    return events["p"].sum(), (~events["p"]).sum(), gaps_us(events).mean()


@pytest.mark.parametrize("level", [0.5, 300.0])
def test_halving_the_step_does_not_change_the_statistics(level: float) -> None:
    """At 0.4 and 0.2 px a step, by night, where noise rules, and by day."""
    coarse, fine = mean_rate(1000, level), mean_rate(500, level)
    assert min(fine[:2]) > 1000
    for count, other in zip(coarse[:2], fine[:2], strict=True):
        assert abs(count - other) < 0.01 * other + 3.0 * math.sqrt(other) * 0.5
    assert coarse[2] == pytest.approx(fine[2], rel=0.03)


@pytest.mark.parametrize("level", [0.3, 100.0])
def test_no_more_events_than_chance_has_it_share_the_time_of_a_frame(level: float) -> None:
    events, _ = run(Davis346(noisy(), seed=1), moving_texture(2000, level=level))
    on_frame = np.sum(events["t"] % 1000 == 0)
    by_chance = events.size / 1000
    assert events.size > 5000
    assert on_frame - by_chance < 0.01 * events.size
    assert on_frame < by_chance + 5.0 * math.sqrt(by_chance)


def test_a_long_stream_does_not_grow() -> None:
    """Ten minutes of stream: as much memory at its end as after its first seconds."""
    sensor, sizes = Davis346(noisy(), seed=1), []
    samples = [frame for _, frame in moving_texture(8, level=0.5)]
    for k in range(6000):
        sensor.step(k * 100_000, samples[k % 8])
        if k in (300, 5999):
            arrays = [*sensor._state, *sensor._work, *sensor._keys]  # type: ignore[misc]
            arrays += [*sensor._arbiter._queue, sensor._arbiter._granted]  # type: ignore[union-attr]
            sizes.append(sum(array.nbytes for array in arrays))
    assert sizes[0] == sizes[1]


def test_state_takes_less_than_forty_bytes_a_pixel() -> None:
    """All that a step changes, frames and readout included; mismatch, drawn once, is 12 bytes."""
    sensor = Davis346(SensorConfig(), seed=1)
    for t_us, luminance in ((0, 1.0), (1000, 2.0)):
        sensor.step(t_us, np.full((260, 346), luminance, np.float32))
    assert sensor._state is not None
    arrays = [*sensor._state, sensor._aps._correction, sensor._arbiter._queue.waits]  # type: ignore[union-attr]
    assert sum(array.nbytes for array in arrays) / (346 * 260) - 12 < 37.1


def test_a_sensor_holds_what_the_readme_says() -> None:
    """Everything, mismatch and lists of events included: 62 bytes a pixel at 346×260."""
    still = np.full((260, 346), 100.0, np.float32)
    Davis346(SensorConfig(width=16, height=16), seed=1).step(0, still[:16, :16])
    tracemalloc.start()
    try:
        sensor = Davis346(SensorConfig(), seed=1)
        for t_us in range(0, 20_000, 1000):
            sensor.step(t_us, still)
        held, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert 57.0 < held / still.size < 64.0


def test_the_chip_grows_noisier_with_heat() -> None:
    """Junction leak and dark current double every 7 K."""
    warm, cool = noisy(temperature_c=46.0), noisy()
    assert warm.warm_leak_hz == pytest.approx(8.0 * cool.warm_leak_hz)
    assert warm.warm_dark_lux == pytest.approx(8.0 * cool.warm_dark_lux)
    bare = quiet(leak_hz=1.0)
    counts = []
    for config in (bare, replace(bare, temperature_c=32.0)):
        frame = flat(1.0, config)
        samples = ((t, frame) for t in range(0, 5_000_001, 50_000))
        counts.append(run(Davis346(config, seed=1), samples)[0].size)
    assert counts[1] == pytest.approx(2 * counts[0], rel=0.02)


def test_heat_hides_contrast_in_the_dark() -> None:
    """Dark current adds to the photocurrent, so a change of light is a smaller change of it."""
    counts = []
    for celsius in (25.0, 60.0):
        config = quiet(temperature_c=celsius)
        low, high = (flat(luminance_for(lux, config), config) for lux in (0.05, 0.5))
        events, _ = run(Davis346(config, seed=1), [(0, low), (1000, high), (2_000_000, high)])
        counts.append(events.size)
    assert counts[0] > 1.5 * counts[1] > 0


def test_dead_pixels_are_silent_and_crazy_ones_fire_both_ways() -> None:
    config = noisy(dead_fraction=0.3, crazy_fraction=0.3, hot_fraction=0.0, crazy_hz_min=200.0)
    events, causes = run(Davis346(config, seed=1), moving_texture(1000, level=30.0))
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
def test_latency_delays_every_event_on_an_unlimited_bus_too(latency_us: int) -> None:
    prompt = replace(noisy(), readout_limit_hz=1e12)
    late = replace(prompt, readout_latency_us=latency_us)
    samples = [(t, flat(1.0 + t / 5000, prompt)) for t in range(0, 40_000, 1000)]
    expected, _ = run(Davis346(prompt, seed=4), samples)
    outputs = list(Davis346(late, seed=4).stream(samples))
    found = np.concatenate([output.events for output in outputs])
    expected["t"] += latency_us
    assert np.array_equal(found, expected[expected["t"] <= 39_000])
    assert outputs[-1].readout.waiting == np.count_nonzero(expected["t"] > 39_000)
    assert max(output.readout.delay_max_us for output in outputs) == latency_us


def test_a_step_of_too_many_frames_is_refused_and_changes_nothing() -> None:
    config = noisy()
    light = flat(5.0, config)
    sensor, other = Davis346(config, seed=3), Davis346(config, seed=3)
    for each in (sensor, other):
        each.step(0, light)
    with pytest.raises(FrameError, match=r"the step is 25000001 µs long.*every 25000 µs.*shorter"):
        sensor.step(25_000_001, 2.0 * light)
    after, expected = sensor.step(1_000_000, light), other.step(1_000_000, light)
    assert np.array_equal(after.events, expected.events)
    assert [f.end_us for f in after.aps_frames] == [f.end_us for f in expected.aps_frames]


@pytest.mark.parametrize("threads", [0, 65, 1.0, True])
def test_threads_that_are_none_are_refused(threads: Any) -> None:
    with pytest.raises(SensorConfigError, match="allowed is a whole number from 1 to 64"):
        Davis346(noisy(), seed=1, threads=threads)


def test_threads_may_be_counted_by_numpy() -> None:
    config = noisy()
    samples = [(t, flat(1.0 + t / 5000, config)) for t in range(0, 5000, 1000)]
    one, _ = run(Davis346(config, seed=4), samples)
    two, _ = run(Davis346(config, seed=4, threads=np.int64(2)), samples)  # type: ignore[arg-type]
    assert np.array_equal(one, two)
