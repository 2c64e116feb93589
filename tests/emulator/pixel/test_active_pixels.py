"""Pixels that are skipped, and the number of threads, change no event."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from emulator import ApsConfig, EventSensor, FrameError, SensorConfig, SensorConfigError
from emulator.pixel.active_pixels import (
    ThreadShare,
    empty_masks,
    find_changed,
    find_due,
    mark_blocks_within,
)
from emulator.pixel.state import BLOCK
from tests.emulator.stimuli import noisy_config, run_sensor, uniform_frame

Frame = np.ndarray[Any, np.dtype[np.float32]]
CHANGED = (30, 20, 62, 41)


def changing_patch(n: int, level: float) -> list[tuple[int, Frame]]:
    """Return frames of a constant texture with a patch of changing noise in `CHANGED`."""
    rng = np.random.default_rng(3)
    background = (level * rng.uniform(0.5, 1.5, (70, 100))).astype(np.float32)
    x0, y0, x1, y1 = CHANGED
    samples = []
    for k in range(n):
        frame = background.copy()
        grain = np.random.default_rng(k // 3).uniform(0.7, 1.4, (y1 - y0, x1 - x0))
        frame[y0:y1, x0:x1] *= grain.astype(np.float32)
        samples.append((k * 1000, frame))
    return samples


def bits(masks: np.ndarray[Any, np.dtype[np.uint64]], pixels: int) -> list[bool]:
    """Return the bit of each pixel."""
    return [bool(int(masks[i // BLOCK]) >> (i % BLOCK) & 1) for i in range(pixels)]


@pytest.mark.parametrize(("width", "height"), [(100, 7), (3, 50), (64, 2), (1, 1)])
@pytest.mark.parametrize("rectangle", [(0, 0, 1, 1), (0, 1, 3, 2), (1, 0, 50, 7), (0, 0, 0, 0)])
def test_the_blocks_that_a_rectangle_touches_are_marked(
    width: int, height: int, rectangle: tuple[int, int, int, int]
) -> None:
    x1, y1 = min(rectangle[2], width), min(rectangle[3], height)
    x0, y0 = min(rectangle[0], x1), min(rectangle[1], y1)
    inside = np.zeros((height, width), bool)
    inside[y0:y1, x0:x1] = True
    compare = empty_masks(width * height).compare
    mark_blocks_within(compare, (x0, y0, x1, y1), width)
    parts = np.split(inside.ravel(), range(BLOCK, inside.size, BLOCK))
    assert compare.tolist() == [bool(part.any()) for part in parts]


@pytest.mark.parametrize("parts", [1, 2, 3])
def test_the_threads_together_find_all_active_pixels(parts: int) -> None:
    pixels = 16 * BLOCK * 3 + 10 * BLOCK + 7
    rng = np.random.default_rng(1)
    before = rng.integers(0, 3, pixels).astype(np.int32)
    after, wake_us = rng.permutation(before), rng.integers(0, 100, pixels).astype(np.int32)
    masks = empty_masks(pixels)
    masks.compare[::5] = False
    block_wake_us = np.zeros(masks.compare.size, np.int32)
    block_wake_us[::3] = 60
    for part in range(parts):
        find_changed(before, after, masks, ThreadShare(part, parts))
        find_due(wake_us, block_wake_us, np.int32(50), masks, ThreadShare(part, parts))
    block = np.arange(pixels) // BLOCK
    assert bits(masks.changed, pixels) == ((before != after) & masks.compare[block]).tolist()
    assert bits(masks.due, pixels) == ((wake_us <= 50) & (block_wake_us[block] <= 50)).tolist()


@pytest.mark.parametrize("level", [0.3, 300.0])
def test_a_changed_rectangle_changes_no_event(level: float) -> None:
    config = SensorConfig(width=100, height=70)
    samples = changing_patch(40, level)
    whole, _ = run_sensor(config, samples)
    sensor = EventSensor(config, seed=1)
    parts = [sensor.step(*sample, changed=CHANGED).events for sample in samples]
    assert np.concatenate(parts).tobytes() == whole.tobytes()
    assert whole.size > 200
    assert whole["x"].min() < 30


def test_an_empty_rectangle_means_that_nothing_has_changed() -> None:
    config = noisy_config()
    frame = uniform_frame(0.5, config)
    whole, _ = run_sensor(config, ((t, frame) for t in range(0, 200_001, 5000)))
    sensor = EventSensor(config, seed=1)
    sensor.step(0, frame)
    parts = [sensor.step(t, frame, changed=(0, 0, 0, 0)).events for t in range(5000, 200_001, 5000)]
    assert np.concatenate(parts).tobytes() == whole.tobytes()
    assert whole.size > 100


@pytest.mark.parametrize(
    "rectangle", [(0, 0, 101, 70), (-1, 0, 5, 5), (5, 5, 4, 6), (0, 0, 1), (0.5, 0, 1, 1), 7]
)
def test_a_rectangle_beyond_the_sensor_is_refused(rectangle: Any) -> None:
    sensor = EventSensor(SensorConfig(width=100, height=70), seed=1)
    samples = changing_patch(2, 1.0)
    sensor.step(*samples[0])
    with pytest.raises(FrameError, match="the changed rectangle is"):
        sensor.step(*samples[1], changed=rectangle)


@pytest.mark.parametrize("threads", [2, 3])
@pytest.mark.parametrize("level", [0.3, 300.0])
def test_threads_change_no_event(threads: int, level: float) -> None:
    config = SensorConfig(width=100, height=70)
    samples = changing_patch(40, level)
    one = run_sensor(config, samples)
    many = run_sensor(config, samples, threads=threads)
    assert many[0].tobytes() == one[0].tobytes()
    assert many[1].tobytes() == one[1].tobytes()
    assert one[0].size > 200


def test_every_thread_finds_invalid_luminance() -> None:
    sensor = EventSensor(SensorConfig(width=100, height=70), seed=1, threads=3)
    (start, frame), (after, other) = changing_patch(2, 1.0)
    sensor.step(start, frame)
    for row, column in ((0, 0), (21, 31), (69, 99)):
        bad = other.copy()
        bad[row, column] = np.nan
        with pytest.raises(FrameError, match=f"nan cd/m² at row {row}, column {column}"):
            sensor.step(after, bad)


@pytest.mark.parametrize("threads", [0, -1, 1.5, True, 100])
def test_an_invalid_number_of_threads_is_refused(threads: Any) -> None:
    with pytest.raises(SensorConfigError, match=f"threads is {threads!r}"):
        EventSensor(noisy_config(), seed=1, threads=threads)


def test_sleeping_pixels_wake_after_hours() -> None:
    """Times are kept modulo 2^32 µs, 71 minutes; the leak continues through many such periods."""
    config = SensorConfig.noise_free(width=16, height=12)
    slow = 1.0 / 4000.0
    aps = ApsConfig(noise=False, period_min_us=10_000_000)
    config = replace(config, leak_hz=slow, theta_mismatch=0.0, aps=aps)
    config = replace(config, leak_spread=0.0, leak_tail_fraction=0.0)
    frame = uniform_frame(1.0, config)
    events, _ = run_sensor(config, ((t * 10**6, frame) for t in range(0, 40_000, 600)))
    pixel = events["y"].astype(int) * 16 + events["x"]
    assert np.all(np.abs(np.bincount(pixel, minlength=192) - 9.9) <= 1)
