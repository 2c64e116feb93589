import math
from dataclasses import replace

import numpy as np
import pytest

from emulator import SensorConfig
from emulator.pixel.noise import (
    draw_gaussians,
    exponential,
    leak_drift,
    noise_law,
    shot_rates,
    uniform,
)
from flybench.events import Cause
from tests.emulator.stimuli import intervals_us, luminance_for_lux, run_sensor, uniform_frame

SEED = np.uint64(12345)


def clean_config(**changes: object) -> SensorConfig:
    """Return a sensor of 3072 pixels without noise, except for the given changes."""
    config = SensorConfig.noise_free(width=64, height=48)
    return replace(config, theta_mismatch=0.0, **changes)  # type: ignore[arg-type]


def static_scene(config: SensorConfig, lux: float, *, seconds: float, step_us: int, seed: int = 3):  # type: ignore[no-untyped-def]
    frame = uniform_frame(luminance_for_lux(lux, config), config)
    times = range(0, round(seconds * 1e6) + 1, step_us)
    return run_sensor(config, ((t, frame) for t in times), seed=seed)


def test_random_numbers_are_uniform_and_independent() -> None:
    grid = np.array([[uniform(SEED, i, k) for k in range(60)] for i in range(200)])
    assert grid.min() > 0.0
    assert grid.max() < 1.0
    assert np.histogram(grid, 10, (0, 1))[0].std() < 120
    assert abs(np.corrcoef(grid[:-1].ravel(), grid[1:].ravel())[0, 1]) < 0.04
    assert abs(np.corrcoef(grid[:, :-1].ravel(), grid[:, 1:].ravel())[0, 1]) < 0.04
    assert uniform(SEED, 3, 4) != uniform(np.uint64(12346), 3, 4)
    drawn = [exponential(SEED, i, 7) for i in range(10_000)]
    assert np.mean(drawn) == pytest.approx(1.0, abs=0.04)
    assert np.std(drawn) == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize(
    ("lux", "on_hz", "off_hz"), [(0.1, 5.6, 4.2), (161.0, 0.104, 0.0012), (3000.0, 0.172, 0.0)]
)
def test_background_activity_matches_the_published_rates(
    lux: float, on_hz: float, off_hz: float
) -> None:
    config = SensorConfig()
    law = noise_law(config)
    on, off = shot_rates(law, math.log(lux + config.dark_lux))
    leak = leak_drift(law, lux + config.dark_lux) / config.theta_on
    assert (on + leak) * 1e6 == pytest.approx(on_hz, rel=0.02)
    assert off * 1e6 == pytest.approx(off_hz, rel=1e-6, abs=1e-4)


@pytest.mark.parametrize(("lux", "seconds"), [(0.1, 0.5), (1.0, 2.0)])
@pytest.mark.parametrize("step_us", [1000, 10_000])
def test_shot_noise_counts_do_not_depend_on_the_step(
    lux: float, seconds: float, step_us: int
) -> None:
    config = clean_config(shot_noise_scale=1.0)
    events, causes = static_scene(config, lux, seconds=seconds, step_us=step_us)
    on, off = shot_rates(noise_law(config), math.log(lux + config.dark_lux))
    assert np.all(causes == Cause.SHOT)
    for rate, found in ((on, events["p"].sum()), (off, (~events["p"]).sum())):
        expected = rate * seconds * 1e6 * config.width * config.height
        assert abs(found - expected) < 4.5 * math.sqrt(expected)


def test_the_step_changes_no_noise_event_under_constant_luminance() -> None:
    config = clean_config(shot_noise_scale=1.0, leak_hz=2.0)
    fine, _ = static_scene(config, 0.3, seconds=0.4, step_us=1000)
    coarse, _ = static_scene(config, 0.3, seconds=0.4, step_us=20_000)
    assert fine.size == coarse.size > 500
    assert np.abs(fine["t"] - coarse["t"]).max() <= 1


def test_shot_noise_is_a_poisson_process() -> None:
    events, _ = static_scene(clean_config(shot_noise_scale=20.0), 0.1, seconds=0.4, step_us=1000)
    gaps = intervals_us(events)
    mean_us = 1e6 / (20.0 * 9.7)
    kept = gaps[gaps < 4 * mean_us]
    observed = np.mean(kept < mean_us)
    assert observed == pytest.approx((1 - math.exp(-1)) / (1 - math.exp(-4)), abs=0.02)


def test_noise_events_do_not_concentrate_at_sample_times() -> None:
    events, _ = static_scene(
        clean_config(shot_noise_scale=1.0, leak_hz=5.0), 0.1, seconds=0.5, step_us=1000
    )
    counts = np.histogram(events["t"] % 1000, 10, (0, 1000))[0]
    assert np.all(np.abs(counts - counts.mean()) < 5 * math.sqrt(counts.mean()))


def test_leak_events_are_on_at_the_given_rate_with_uniform_phases() -> None:
    events, causes = static_scene(clean_config(leak_hz=1.0), 100.0, seconds=2.0, step_us=20_000)
    assert np.all(causes == Cause.LEAK)
    assert events["p"].all()
    assert events.size == pytest.approx(2.0 * 3072, rel=0.01)
    phases = np.histogram(events["t"][events["t"] <= 1_000_000], 10, (0, 1_000_000))[0]
    assert phases.min() > 0.75 * 307
    gaps = intervals_us(events)
    assert np.all(np.abs(gaps - 1_000_000) <= 20)


def test_leak_grows_with_illuminance() -> None:
    config = clean_config(leak_hz=0.1, leak_hz_per_lux=2.4e-5)
    events, _ = static_scene(config, 100_000.0, seconds=1.0, step_us=20_000)
    assert events.size == pytest.approx(2.5 * 3072, rel=0.02)


def test_only_hot_pixels_fire_and_at_their_rates() -> None:
    events, causes = static_scene(clean_config(hot_fraction=0.01), 100.0, seconds=2.0, step_us=5000)
    assert np.all(causes == Cause.HOT)
    pixels, counts = np.unique(events["y"].astype(int) * 64 + events["x"], return_counts=True)
    assert 10 <= pixels.size <= 60
    assert counts.mean() / 2.0 == pytest.approx(50.5, rel=0.1)


def test_noise_resets_the_pixel() -> None:
    """With random events in between, a slow rise no longer reaches the threshold."""
    clean, noisy = clean_config(), clean_config(shot_noise_scale=200.0)

    def signals(config: SensorConfig) -> int:
        level = luminance_for_lux(0.1, config)
        samples = [
            (t, uniform_frame(level * math.exp(t * 1e-6), config)) for t in range(0, 300_001, 5000)
        ]
        _, causes = run_sensor(config, samples)
        return int((causes == Cause.SIGNAL).sum())

    assert signals(clean) >= 3072
    assert signals(noisy) < 100


def test_gaussians_are_gaussian_and_independent() -> None:
    drawn = np.empty(400_001, np.float32)
    draw_gaussians(SEED, np.uint64(0), drawn)
    wide = drawn.astype(np.float64)
    assert abs(wide.mean()) < 0.006
    assert wide.std() == pytest.approx(1.0, abs=0.004)
    assert abs(np.mean(wide**3)) < 0.02
    assert np.mean(wide**4) == pytest.approx(3.0, abs=0.06)
    for sigmas, share in ((1.0, 0.31731), (2.0, 0.0455), (3.0, 0.0027)):
        assert np.mean(np.abs(wide) > sigmas) == pytest.approx(share, rel=0.1)
    for lag in (1, 2, 346, 200_000):
        assert abs(np.mean(wide[lag:] * wide[:-lag])) < 0.01
    other, later = np.empty(1000, np.float32), np.empty(1000, np.float32)
    draw_gaussians(np.uint64(7), np.uint64(0), other)
    draw_gaussians(SEED, np.uint64(10**6), later)
    assert abs(np.corrcoef(wide[:1000], other)[0, 1]) < 0.15
    assert abs(np.corrcoef(wide[:1000], later)[0, 1]) < 0.15
