"""The compiled kernel against a reference in plain Python, for one pixel and without shortcuts."""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from emulator import SensorConfig
from tests.emulator.stimuli import luminance_for_lux, noise_free_config, run_sensor, uniform_frame

CONFIG = noise_free_config(width=1, height=1, refractory_us=50)

Found = tuple[float, bool, float]


def pieces(
    samples: list[tuple[int, float]], config: SensorConfig
) -> Iterator[tuple[float, float, float, float]]:
    """Yield start, span, slope and τ of each segment on which u is linear and τ constant."""
    per_us = 2e-6 * math.pi
    for (t0, e0), (t1, e1) in pairwise(samples):
        u0, u1 = math.log(e0 + config.dark_lux), math.log(e1 + config.dark_lux)
        limit = math.log(config.bandwidth_limit_hz / config.bandwidth_hz_per_lux)
        n = 1 if min(u0, u1) >= limit else 1 + int(abs(u1 - u0) / 0.25)
        for k in range(n):
            middle = u0 + (k + 0.5) * (u1 - u0) / n
            cutoff = min(config.bandwidth_limit_hz, config.bandwidth_hz_per_lux * math.exp(middle))
            span = (t1 - t0) / n
            yield t0 + k * span, span, (u1 - u0) / (t1 - t0), 1.0 / (per_us * cutoff)


def reference(samples: list[tuple[int, float]], config: SensorConfig) -> tuple[list[Found], float]:
    """Return events (time, polarity, slope of the difference there), and the narrowest miss."""
    lag = d = reset = 0.0
    found: list[Found] = []
    nearest = 1.0
    for start, span, slope, tau in pieces(samples, config):
        at = 0.0
        while span - at > 1e-9:
            if reset > 0.0:
                wait = min(reset, span - at)
                lag = slope * tau + (lag - slope * tau) * math.exp(-wait / tau)
                reset, at, d = reset - wait, at + wait, 0.0
                continue
            swing = lag - slope * tau
            s = np.linspace(0.0, span - at, 4001)
            course = d + slope * s + swing * (1.0 - np.exp(-s / tau))
            out = np.flatnonzero((course >= config.theta_on) | (course <= -config.theta_off))
            wait = span - at
            if out.size:
                on = bool(course[out[0]] > 0)
                level = config.theta_on if on else -config.theta_off
                low, high = float(s[out[0] - 1]), float(s[out[0]])
                for _ in range(60):
                    wait = 0.5 * (low + high)
                    value = d + slope * wait + swing * (1.0 - math.exp(-wait / tau))
                    low, high = (low, wait) if (value > level) == on else (wait, high)
                rise = slope + swing / tau * math.exp(-wait / tau)
                found.append((start + at + wait, on, rise))
                reset = float(config.refractory_us)
            else:
                nearest = min(
                    nearest, config.theta_on - course.max(), course.min() + config.theta_off
                )
            new_lag = slope * tau + (lag - slope * tau) * math.exp(-wait / tau)
            d = 0.0 if out.size else d + slope * wait - (new_lag - lag)
            lag, at = new_lag, at + wait
    return found, nearest


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(st.integers(100, 20_000), st.floats(-3.0, 5.0)), min_size=2, max_size=6))
def test_the_kernel_matches_the_reference(walk: list[tuple[int, float]]) -> None:
    times = np.cumsum([0, *(step for step, _ in walk)])
    levels = [1.0, *(math.exp(log) for _, log in walk)]
    frames = [uniform_frame(luminance_for_lux(lux, CONFIG), CONFIG) for lux in levels]
    scale = 1.0 / luminance_for_lux(1.0, CONFIG)
    lux = [float(np.float64(frame[0, 0]) * scale) for frame in frames]
    expected, nearest = reference([(int(t), e) for t, e in zip(times, lux, strict=True)], CONFIG)
    assume(nearest > 1e-5)
    assume(all(abs(slope) > 1e-6 for _, _, slope in expected))
    samples = [(int(t), frame) for t, frame in zip(times, frames, strict=True)]
    events, _ = run_sensor(CONFIG, samples)
    edge = [int(times[-1]) - t < 30 for t, _, _ in expected]
    shared = len(expected) - sum(edge)
    assert shared <= events.size <= len(expected) + 1
    for event, (t, on, slope) in zip(events[:shared], expected, strict=False):
        assert bool(event["p"]) == on
        assert abs(int(event["t"]) - math.ceil(t)) <= 2 + 1e-5 / abs(slope)
