from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emulator import ApsConfig, ApsFrame, EventSensor, SensorConfig, SensorConfigError
from emulator.aps.exposure import add_correction, trapezoid_weights
from emulator.pixel.state import BLOCK
from tests.emulator.stimuli import luminance_for_lux, noise_free_config, noisy_config, uniform_frame

FIXED = ApsConfig(noise=False, auto_exposure=False, exposure_us=10_000)


def frames_of(
    config: SensorConfig, lux: float, *, seconds: float = 1.0, step_us: int = 1000
) -> list[ApsFrame]:
    sensor = EventSensor(config, seed=1)
    frame = uniform_frame(luminance_for_lux(lux, config), config)
    times = range(500, round(seconds * 1e6) + 501, step_us)
    return [found for t in times for found in sensor.step(t, frame).aps_frames]


@pytest.mark.parametrize("width", [5, 70])
def test_changed_pixels_are_corrected_by_the_weight_of_their_row(width: int) -> None:
    rng = np.random.default_rng(1)
    before, after = rng.uniform(0.0, 9.0, (2, 30, width)).astype(np.float32)
    changed = rng.random((30, width)) < 0.3
    changed[5:20] = False
    weights = rng.uniform(0.0, 1e-3, 30)
    marks = np.zeros((-(-changed.size // BLOCK), BLOCK), np.uint8)
    marks.ravel()[: changed.size] = changed.ravel()
    masks = np.packbits(marks, axis=1, bitorder="little").view("<u8").ravel().astype(np.uint64)
    found = np.zeros(changed.size, np.float32)
    add_correction(found, before.ravel(), after.ravel(), masks, weights, width)
    expected = np.where(changed, (before - after) * weights[:, np.newaxis], 0.0)
    assert found.reshape(changed.shape) == pytest.approx(expected, rel=1e-5)


def test_levels_are_linear_in_illuminance() -> None:
    config = noise_free_config(aps=FIXED, dark_lux=1e-6)
    per_lux = FIXED.electrons_per_lux_s * 0.01 / FIXED.electrons_per_dn
    for lux in (1.0, 4.0, 16.0):
        image = frames_of(config, lux, seconds=0.1)[0].image
        assert image.dtype == np.uint16
        assert image.shape == (12, 16)
        assert np.all(np.abs(image - per_lux * lux) <= 0.51)


def test_bright_frames_saturate() -> None:
    assert np.all(
        frames_of(noise_free_config(aps=FIXED), 1e4, seconds=0.1)[0].image == FIXED.saturation_dn
    )


@given(
    cuts=st.lists(st.integers(1, 9_999), max_size=8, unique=True),
    start=st.integers(0, 4000),
    length=st.integers(1, 6000),
)
def test_the_exposure_does_not_depend_on_how_it_is_cut(
    cuts: list[int], start: int, length: int
) -> None:
    bounds = [0, *sorted(cuts), 10_000]
    luminance = [3.0 + 0.002 * t for t in bounds]
    end, total, duration = start + length, 0.0, 0.0
    for (a, b), (e0, e1) in zip(pairwise(bounds), pairwise(luminance), strict=True):
        if a < end and b > start:
            w0, w1 = trapezoid_weights(a, b, max(a, start), min(b, end))
            total, duration = total + w0 * e0 + w1 * e1, duration + w0 + w1
    assert duration == pytest.approx(length * 1e-6)
    assert total == pytest.approx(length * 1e-6 * (3.0 + 0.002 * (start + end) / 2))


@pytest.mark.parametrize("step_us", [100, 1000, 20_000])
def test_frames_do_not_depend_on_the_steps(step_us: int) -> None:
    frames = frames_of(noise_free_config(), 50.0, step_us=step_us)
    reference = frames_of(noise_free_config(), 50.0, step_us=500)
    assert len(frames) >= 39
    for frame, other in zip(frames, reference, strict=False):
        assert (frame.start_us, frame.end_us) == (other.start_us, other.end_us)
        assert np.abs(frame.image.astype(int) - other.image).max() <= 1


def test_a_moving_edge_is_blurred_over_its_path() -> None:
    config = noise_free_config(aps=FIXED, dark_lux=1e-6)
    sensor, level = EventSensor(config, seed=1), luminance_for_lux(8.0, config)
    for t_us in range(0, 10_001, 100):
        covered = np.clip(2.0 + 8.0 * t_us / 10_000 - np.arange(16), 0.0, 1.0)
        frame = np.tile((level * covered).astype(np.float32), (12, 1))
        output = sensor.step(t_us, frame)
    row = output.aps_frames[0].image[0].astype(int)
    full = row[0]
    assert full > 200
    assert np.all(row[11:] == 0)
    assert np.abs(row[2:10] - full * (1 - (np.arange(2, 10) - 2 + 0.5) / 8)).max() <= 3


def test_the_variance_is_that_of_photons_and_read_noise() -> None:
    config = replace(
        SensorConfig(width=64, height=48),
        aps=replace(FIXED, noise=True, fixed_pattern=0.0),
        dark_lux=1e-6,
    )
    for lux in (2.0, 10.0):
        images = np.stack([f.image for f in frames_of(config, lux, seconds=0.5)]).astype(float)
        electrons = FIXED.electrons_per_lux_s * 0.01 * lux
        variance = (electrons + FIXED.read_noise_e**2) / FIXED.electrons_per_dn**2 + 1 / 12
        assert images.var() == pytest.approx(variance, rel=0.05)
        assert images.mean() == pytest.approx(electrons / FIXED.electrons_per_dn, rel=0.01)


def test_40_frames_per_second_by_day_and_fewer_than_10_at_night() -> None:
    day = frames_of(noisy_config(), 300.0)
    assert len(day) == 40
    assert all(b.start_us - a.start_us == 25_000 for a, b in pairwise(day))
    night = frames_of(noisy_config(), 0.3, seconds=3.0)
    assert 3 <= len(night) / 3.0 < 10


@pytest.mark.parametrize("lux", [0.5, 10.0, 1000.0])
def test_auto_exposure_reaches_its_target(lux: float) -> None:
    config = noise_free_config()
    last = frames_of(config, lux, seconds=2.0)[-1]
    assert last.image.mean() == pytest.approx(config.aps.target_dn, rel=0.03)


def test_auto_exposure_follows_a_change_of_luminance() -> None:
    config = noise_free_config()
    sensor = EventSensor(config, seed=1)
    found: list[ApsFrame] = []
    for t_us in range(0, 1_500_001, 1000):
        lux = 100.0 if t_us < 500_000 else 5.0
        output = sensor.step(t_us, uniform_frame(luminance_for_lux(lux, config), config))
        found += output.aps_frames
    assert found[-1].exposure_us == pytest.approx(20 * found[5].exposure_us, rel=0.03)


def test_exposures_do_not_overlap() -> None:
    frames = frames_of(noisy_config(), 2.0, seconds=2.0)
    config = noisy_config().aps
    assert frames[0].start_us == 500
    for a, b in pairwise(frames):
        assert a.exposure_us == a.end_us - a.start_us > 0
        assert b.start_us == max(a.start_us + config.period_min_us, a.end_us + config.readout_us)


def test_noise_is_seeded() -> None:
    first, second = (
        frames_of(noisy_config(), 5.0, seconds=0.2),
        frames_of(noisy_config(), 5.0, seconds=0.2),
    )
    assert all(np.array_equal(a.image, b.image) for a, b in zip(first, second, strict=True))
    assert not np.array_equal(first[0].image, first[1].image)


def test_fixed_pattern_noise_is_constant() -> None:
    aps = replace(FIXED, noise=True, fixed_pattern=0.05, read_noise_e=0.0)
    config = replace(SensorConfig(width=64, height=48), aps=aps, dark_lux=1e-6)
    images = np.stack([f.image for f in frames_of(config, 10.0, seconds=1.0)]).astype(float)
    pattern = images.mean(axis=0)
    assert pattern.std() / pattern.mean() == pytest.approx(0.05, rel=0.1)
    without_noise = replace(aps, noise=False)
    uniform = frames_of(replace(config, aps=without_noise), 10.0, seconds=0.1)
    assert uniform[0].image.std() == 0.0


def test_a_rolling_shutter_slants_a_moving_edge() -> None:
    """Each row is exposed later than the one before, and sees the edge further along."""
    aps = replace(FIXED, shutter="rolling", exposure_us=1000, readout_us=12_000)
    config = noise_free_config(aps=aps, dark_lux=1e-6)
    sensor, level = EventSensor(config, seed=1), luminance_for_lux(80.0, config)
    frames: list[ApsFrame] = []
    for t_us in range(0, 26_001, 250):
        covered = np.clip(2.0 + t_us / 1000.0 - np.arange(16), 0.0, 1.0)
        frame = np.tile((level * covered).astype(np.float32), (12, 1))
        frames += sensor.step(t_us, frame).aps_frames
    first = frames[0]
    full = FIXED.electrons_per_lux_s * 80.0 * 1e-3 / FIXED.electrons_per_dn
    edge = first.image.astype(float).sum(axis=1) / full
    assert first.rolling_us == 11_000
    assert first.exposure_us == 1000
    assert edge == pytest.approx(2.5 + np.arange(12), abs=0.02)


@pytest.mark.parametrize("step_us", [100, 1000, 30_000])
def test_rolling_frames_do_not_depend_on_the_steps(step_us: int) -> None:
    config = noise_free_config(aps=ApsConfig(noise=False, shutter="rolling"))
    frames = frames_of(config, 5.0, step_us=step_us)
    reference = frames_of(config, 5.0, step_us=500)
    assert len(frames) > 5
    for frame, other in zip(frames, reference, strict=False):
        assert (frame.start_us, frame.end_us) == (other.start_us, other.end_us)
        assert np.abs(frame.image.astype(int) - other.image).max() <= 1


def test_an_unknown_shutter_is_refused() -> None:
    with pytest.raises(
        SensorConfigError, match=r"shutter is 'leaf'\. Allowed is one of global, rol"
    ):
        ApsConfig(shutter="leaf")  # type: ignore[arg-type]
