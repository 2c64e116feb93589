"""If nothing moves, the fly gives no direction: in noise of any rate and at any illuminance."""

from functools import cache

import cv2
import numpy as np
import pytest

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyConfig, FlyDetector
from emulator import EventSensor, SensorConfig
from flybench.direction import Direction
from flybench.events import Events
from tests.detector.stimuli import asphalt, hot_pixels, merged, noise

PRESETS = ["paper", "wide", "robust"]
SECOND_US = 1_000_000


def estimates_of(preset: str, events: Events, until_us: int = SECOND_US) -> list[MotionEstimate]:
    fly = FlyDetector(FlyConfig.preset(preset))
    return fly.push(events) + fly.advance(until_us)


def share_of_none(found: list[MotionEstimate]) -> float:
    return float(np.mean([e.direction is Direction.NONE for e in found]))


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("rate_hz", [0.1, 1.0, 3.0, 5.0, 10.0, 20.0])
def test_noise_alone_gives_none(preset: str, rate_hz: float) -> None:
    events = merged(
        noise(rate_hz, duration_us=SECOND_US, seed=7),
        hot_pixels(20, 50, duration_us=SECOND_US, seed=8),
    )
    found = estimates_of(preset, events)
    assert len(found) == SECOND_US // FlyConfig.preset(preset).hop_us
    assert share_of_none(found) >= 0.99


@cache
def still_street(lux: float) -> Events:
    """Return one second of events of a still street from a sensor with all noise sources."""
    reflectance = 0.2 * np.exp(asphalt(260, 346, seed=3))
    luminance = (lux * reflectance / np.pi).astype(np.float32)
    sensor = EventSensor(SensorConfig(), seed=3)
    steps = range(0, SECOND_US + 1, 10_000)
    events = np.concatenate([sensor.step(t_us, luminance).events for t_us in steps])
    return events[events["t"] < SECOND_US]


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("lux", [0.1, 1.0, 10.0, 1_000.0, 100_000.0])
def test_a_still_street_gives_none_at_any_illuminance(preset: str, lux: float) -> None:
    events = still_street(lux)
    assert events.size > 1_000
    assert share_of_none(estimates_of(preset, events)) >= 0.99


@cache
def flickering_texture(depth: float, *, duration_us: int = 300_000) -> Events:
    """Return events of a still texture of 20 to 180 cd/m² whose luminance flickers at 100 Hz."""
    random = np.random.default_rng(0).random((260, 346)).astype(np.float32)
    texture = cv2.GaussianBlur(random, (0, 0), 2.0)
    luminance = 200 * (0.1 + 0.8 * (texture - texture.min()) / np.ptp(texture))
    sensor, parts = EventSensor(SensorConfig(), seed=1), []
    for t_us in range(0, duration_us + 1, 1_000):
        gain = 1 + depth * np.sin(2 * np.pi * 100 * t_us * 1e-6)
        parts.append(sensor.step(t_us, (luminance * gain).astype(np.float32)).events)
    return np.concatenate(parts)


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize(("depth", "least"), [(0.1, 1.0), (0.2, 0.7)])
def test_a_still_scene_in_flickering_light_gives_none(
    preset: str, depth: float, least: float
) -> None:
    # At a depth of 0.2 the bus is saturated for a part of the time, and columns are read in bursts.
    events = flickering_texture(depth)
    assert events.size > (10_000 if depth == 0.1 else 100_000)
    assert share_of_none(estimates_of(preset, events, 300_000)) >= least


def test_without_the_share_floor_flickering_light_gives_directions() -> None:
    fly = FlyDetector(FlyConfig(share_floor=0.0))
    events = flickering_texture(0.4, duration_us=120_000)
    found = fly.push(events) + fly.advance(120_000)
    assert share_of_none(found) < 0.8


@pytest.mark.parametrize("preset", PRESETS)
def test_a_single_flickering_spot_gives_none(preset: str) -> None:
    # 36 pixels fire together at 100 Hz: a strong response without motion.
    rows, columns = np.mgrid[100:106, 100:106]
    spot = np.zeros((36, 100), noise(0.1, duration_us=1).dtype)
    spot["t"] = np.arange(100) * 10_000
    spot["x"], spot["y"], spot["p"] = columns.reshape(-1, 1), rows.reshape(-1, 1), True
    events = np.sort(spot.ravel(), order="t", kind="stable")
    found = estimates_of(preset, merged(events, noise(1.0, duration_us=SECOND_US)))
    assert share_of_none(found) >= 0.99
