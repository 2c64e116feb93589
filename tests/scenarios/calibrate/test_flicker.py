"""Frequency and depth of a lamp that flickers, on made events."""

import math

import numpy as np
import pytest

from emulator import ApsFrame
from flybench.events import EVENT_DTYPE, Events
from scenarios.calibrate.fits.flicker import Flicker, find_flicker
from scenarios.calibrate.recording import CalibrationRecording, events_by_pixel

SIDE = 32


def lamp(hz: float, *, seconds: float, rises: int, pixels: int = 100, seed: int = 0) -> Events:
    """Events of pixels that see a lamp, which rises `rises` thresholds in each period."""
    rng = np.random.default_rng(seed)
    periods = int(hz * seconds)
    start = np.arange(periods) / hz
    parts = []
    for number in range(pixels):
        for on, phase in ((True, 0.2), (False, 0.7)):
            t = np.repeat(start, rises) + (phase + 0.02 * rng.standard_normal(periods * rises)) / hz
            events = np.zeros(t.size, EVENT_DTYPE)
            events["t"], events["p"] = np.rint(1e6 * np.abs(t)), on
            events["x"], events["y"] = number % SIDE, number // SIDE
            parts.append(events)
    return np.sort(np.concatenate(parts), order="t")


def noise(rate_hz: float, *, seconds: float, seed: int = 1) -> Events:
    rng = np.random.default_rng(seed)
    events = np.zeros(rng.poisson(rate_hz * seconds * SIDE * SIDE), EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, round(1e6 * seconds), events.size))
    events["x"], events["y"] = rng.integers(0, SIDE, (2, events.size))
    events["p"] = rng.random(events.size) < 0.5
    return events


def found_in(events: Events) -> Flicker | None:
    image = np.full((SIDE, SIDE), 100, np.uint16)
    frames = (ApsFrame(0, 1000, image), ApsFrame(40_000, 41_000, image))
    recording = CalibrationRecording(events, frames, np.ones(2))
    return find_flicker(recording, events_by_pixel(events, (SIDE, SIDE)), 0.25)


@pytest.mark.parametrize("hz", [100.0, 120.0, 99.3])
def test_frequency_and_depth_are_found_in_noise(hz: float) -> None:
    both = np.concatenate([lamp(hz, seconds=0.3, rises=2), noise(2.0, seconds=0.3)])
    found = found_in(np.sort(both, order="t"))
    assert found is not None
    assert found.hz == pytest.approx(hz, abs=0.3)
    assert found.pixels == pytest.approx(100, abs=5)
    assert found.depth == pytest.approx(math.tanh(0.25), rel=0.15)


def test_noise_alone_does_not_flicker() -> None:
    assert found_in(noise(20.0, seconds=0.3)) is None


def test_a_short_recording_tells_nothing() -> None:
    assert found_in(lamp(100.0, seconds=0.08, rises=2)) is None
