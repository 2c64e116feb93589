"""Noise that crosses thresholds: the fast kernels against an exact simulation."""

import hashlib
import math
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from emulator import EventSensor, SensorConfig
from emulator.readout.config import UNLIMITED
from flybench.events import Cause, Events
from tests.emulator.pixel.exact_noise import ExactPixel, exact_events
from tests.emulator.stimuli import (
    HEIGHT,
    WIDTH,
    Sample,
    intervals_us,
    luminance_for_lux,
    moving_texture,
    run_sensor,
    uniform_frame,
)

SIDE = 20
EDGE_SIDE = 80
Reals = npt.NDArray[np.float64]


def noisy(**changes: Any) -> SensorConfig:
    """Return a sensor of 400 pixels with photoreceptor noise only, and 1 Hz of cutoff per lux."""
    config = SensorConfig.noise_free(width=SIDE, height=SIDE)
    plain = {
        "theta_on": 1.0,
        "theta_off": 1.33,
        "theta_mismatch": 0.085,
        "bandwidth_hz_per_lux": 1.0,
        "bandwidth_limit_hz": 1e6,
        "dark_lux": 1e-6,
        "dark_current_spread": 0.0,
        "leak_spread": 0.0,
        "leak_tail_fraction": 0.0,
        "follower_hz": 0.0,
        "refractory_us": 3,
        "readout": UNLIMITED,
    }
    return replace(config, **{**plain, **changes})


def still(config: SensorConfig, lux: float, seconds: float, step_us: int) -> list[Sample]:
    frame = uniform_frame(luminance_for_lux(lux, config), config)
    return [(t, frame) for t in range(0, round(seconds * 1e6) + 1, step_us)]


def thresholds(config: SensorConfig, seed: int) -> tuple[Reals, Reals]:
    pixels = EventSensor(config, seed=seed)._pixels
    return pixels["theta_on"].astype(np.float64), pixels["theta_off"].astype(np.float64)


class Found:
    """What is compared: rates [Hz], variation of intervals, share of alternations."""

    def __init__(
        self, pixel: npt.ArrayLike, t_us: npt.ArrayLike, on: npt.ArrayLike, seconds: float
    ):
        pixel, t_us, on = np.asarray(pixel), np.asarray(t_us), np.asarray(on, np.bool_)
        order = np.lexsort((t_us, pixel))
        pixel, t_us, on = pixel[order], t_us[order], on[order]
        per_s = 1.0 / (SIDE * SIDE * seconds)
        self.on_hz, self.off_hz = on.sum() * per_s, (~on).sum() * per_s
        self.alternation = (on[1:] != on[:-1])[np.diff(pixel) == 0].mean()
        gaps = np.diff(t_us[on])[np.diff(pixel[on]) == 0]
        self.variation = gaps.std() / gaps.mean()


def of_sensor(events: Events, seconds: float) -> Found:
    pixel = events["y"].astype(int) * SIDE + events["x"]
    return Found(pixel, events["t"], events["p"], seconds)


@pytest.mark.parametrize(
    ("lux", "changes", "seconds"),
    [
        (13.8, {"noise_sigma": 0.42}, 20.0),
        (13.8, {"noise_sigma": 0.30, "leak_hz": 0.2}, 60.0),
        (60.0, {"noise_sigma": 0.30, "leak_hz": 0.5, "refractory_us": 2000}, 12.0),
        (27.0, {"noise_sigma": 0.42, "theta_off": 1.25, "follower_hz": 286.0}, 8.0),
        (
            100.0,
            {
                "noise_sigma": 0.42,
                "theta_off": 1.25,
                "follower_hz": 286.0,
                "leak_hz": 0.1,
                "refractory_us": 270,
            },
            12.0,
        ),
    ],
    ids=["noise", "leak", "refractory", "follower", "follower and refractory"],
)
def test_events_of_a_still_scene_are_those_of_the_exact_simulation(
    lux: float, changes: dict[str, Any], seconds: float
) -> None:
    config = noisy(**changes)
    events, _ = run_sensor(config, still(config, lux, seconds, 100_000), seed=2)
    found = of_sensor(events, seconds)
    theta_on, theta_off = thresholds(config, 2)
    tau_us = 1e6 / (2.0 * math.pi * lux)
    follower_us = 1e6 / (2.0 * math.pi * config.follower_hz) if config.follower_hz else 0.0
    share = tau_us / (tau_us + follower_us)
    exact = exact_events(
        ExactPixel(
            sigma=config.noise_sigma * math.sqrt(share),
            tau_us=tau_us,
            follower_us=follower_us,
            refractory_us=config.refractory_us,
            leak_per_us=config.leak_hz * config.theta_on * 1e-6,
        ),
        theta_on,
        theta_off,
        times_us=np.array([0.0, seconds * 1e6]),
        log_lux=np.zeros(2),
        phase=theta_on * np.random.default_rng(1).random(theta_on.size),
        settle_us=5e6,
        seed=3,
    )
    expected = Found(exact.pixel, exact.t_us, exact.on, seconds)
    within = 0.05 if config.follower_hz else 0.03
    assert found.on_hz == pytest.approx(expected.on_hz, rel=within)
    assert found.off_hz == pytest.approx(expected.off_hz, rel=within)
    ratio, expected_ratio = found.on_hz / found.off_hz, expected.on_hz / expected.off_hz
    assert ratio == pytest.approx(expected_ratio, rel=0.03)
    assert found.alternation == pytest.approx(expected.alternation, abs=0.03)
    assert found.variation == pytest.approx(expected.variation, rel=0.08)


@pytest.mark.parametrize("contrast", [0.7, 0.9, 1.1, 1.4, 5.0])
@pytest.mark.parametrize(
    ("follower_hz", "ramp_us", "step_us"),
    [(0.0, 4_000, 250), (0.0, 4_000, 1000), (286.0, 4_000, 1000), (286.0, 100_000, 1000)],
)
def test_noise_softens_the_response_to_an_edge_as_in_the_exact_simulation(
    contrast: float, follower_hz: float, ramp_us: int, step_us: int
) -> None:
    """The S-curve, and the jitter of the first event.

    Thresholds are low, so that the light hardly changes: the exact pixel has constant rates.
    """
    theta_on, theta_off, sigma_0, cutoff_hz = 0.01, 0.012, 0.0013, 30.0
    config = noisy(
        theta_on=theta_on,
        theta_off=theta_off,
        theta_mismatch=0.0,
        noise_sigma=sigma_0,
        follower_hz=follower_hz,
        width=EDGE_SIDE,
        height=EDGE_SIDE,
    )
    pixels = EDGE_SIDE * EDGE_SIDE
    times = np.arange(0, 110_001 + ramp_us, step_us)
    log_lux = math.log(cutoff_hz) + theta_on * contrast * (
        np.clip((times - 10_000) / ramp_us, 0.0, 1.0) - 0.5
    )
    frames = [uniform_frame(luminance_for_lux(math.exp(u), config), config) for u in log_lux]
    events, _ = run_sensor(config, zip(times.tolist(), frames, strict=True), seed=5)
    on = events[events["p"]]
    pixel = on["y"].astype(int) * EDGE_SIDE + on["x"]
    tau_us = 1e6 / (2.0 * math.pi * cutoff_hz)
    follower_us = 1e6 / (2.0 * math.pi * follower_hz) if follower_hz else 0.0
    exact = exact_events(
        ExactPixel(
            sigma=sigma_0 * math.sqrt(tau_us / (tau_us + follower_us)),
            tau_us=tau_us,
            follower_us=follower_us,
            refractory_us=config.refractory_us,
        ),
        np.full(pixels, theta_on),
        np.full(pixels, theta_off),
        times_us=times.astype(np.float64),
        log_lux=log_lux,
        phase=np.zeros(pixels),
        settle_us=0.0,
        seed=6,
        steps_per_tau=24 if follower_hz else 96,
    )
    rising = exact.on
    found, first = np.unique(pixel, return_index=True)
    expected, first_exact = np.unique(exact.pixel[rising], return_index=True)
    assert found.size == pytest.approx(expected.size, abs=0.035 * pixels)
    assert on.size == pytest.approx(rising.sum(), abs=0.035 * pixels)
    if contrast > 0.8:
        t_us, t_exact_us = on["t"][first], exact.t_us[rising][first_exact]
        assert t_us.std() == pytest.approx(t_exact_us.std(), rel=0.1)
        assert t_us.mean() == pytest.approx(t_exact_us.mean(), abs=0.12 * t_exact_us.std())


@pytest.mark.parametrize(
    ("cutoff_hz", "signal_hz", "amplitude", "within"),
    [(20.0, 50.0, 2.0, 0.1), (20.0, 20.0, 2.0, 0.05), (60.0, 50.0, 1.5, 0.05)],
)
def test_a_moving_signal_has_as_many_events_as_in_the_exact_simulation(
    cutoff_hz: float, signal_hz: float, amplitude: float, within: float
) -> None:
    """A sine of a few thresholds, with the ratios of the default; the light hardly changes."""
    theta_on, seconds = 0.028, 4.0
    config = noisy(
        theta_on=theta_on,
        theta_off=1.25 * theta_on,
        theta_mismatch=0.085 * theta_on,
        noise_sigma=0.25 * theta_on,
        follower_hz=286.0,
        refractory_us=270,
    )
    times = np.arange(0, round(seconds * 1e6) + 1, 1000)
    turns = signal_hz * 1e-6 * times
    log_lux = math.log(cutoff_hz) + amplitude * theta_on * np.sin(2.0 * math.pi * turns)
    frames = (uniform_frame(luminance_for_lux(math.exp(u), config), config) for u in log_lux)
    events, _ = run_sensor(config, zip(times.tolist(), frames, strict=True), seed=2)
    on, off = thresholds(config, 2)
    tau_us, follower_us = (1e6 / (2.0 * math.pi * hz) for hz in (cutoff_hz, config.follower_hz))
    exact = exact_events(
        ExactPixel(
            sigma=config.noise_sigma * math.sqrt(tau_us / (tau_us + follower_us)),
            tau_us=tau_us,
            follower_us=follower_us,
            refractory_us=config.refractory_us,
        ),
        on,
        off,
        times_us=times.astype(np.float64),
        log_lux=log_lux,
        phase=on * np.random.default_rng(1).random(on.size),
        settle_us=1e6,
        seed=3,
    )
    rising = np.count_nonzero(exact.on)
    assert rising > 10_000
    assert np.count_nonzero(events["p"]) == pytest.approx(rising, rel=within)
    assert np.count_nonzero(~events["p"]) == pytest.approx(exact.on.size - rising, rel=within)


def test_the_step_changes_no_event_of_a_still_scene() -> None:
    """From 0.1 ms to 1 s, with a leak, a follower and a refractory period."""
    config = noisy(noise_sigma=0.42, leak_hz=0.5, follower_hz=286.0, refractory_us=270)
    streams = [
        run_sensor(config, still(config, 13.8, 2.0, step))[0].tobytes()
        for step in (100, 1000, 50_000, 1_000_000)
    ]
    assert len(streams[0]) > 10_000
    assert streams.count(streams[0]) == 4


def test_cuts_and_threads_change_no_event_of_a_moving_scene() -> None:
    config = SensorConfig(width=WIDTH, height=HEIGHT, noise_sigma=0.12)
    samples = list(moving_texture(300, level=0.3))
    whole, _ = run_sensor(config, samples)
    sensor = EventSensor(config, seed=1)
    cut = [
        o.events
        for part in (samples[:7], samples[7:150], samples[150:])
        for o in sensor.stream(part)
    ]
    threaded, _ = run_sensor(config, samples, threads=3)
    assert whole.size > 500
    assert np.concatenate(cut).tobytes() == whole.tobytes() == threaded.tobytes()


def test_a_detector_that_resets_to_what_it_sees_conserves_its_input() -> None:
    """On a still scene, θ_on·rate_on − θ_off·rate_off is the leak, in every pixel."""
    config = noisy(noise_sigma=0.42, leak_hz=0.5, theta_mismatch=0.1)
    seconds = 60.0
    events, _ = run_sensor(config, still(config, 13.8, seconds, 1_000_000), seed=4)
    pixel = events["y"].astype(int) * SIDE + events["x"]
    on, off = (
        np.bincount(pixel[events["p"] == polarity], minlength=SIDE * SIDE) for polarity in (1, 0)
    )
    theta_on, theta_off = thresholds(config, 4)
    drift_per_s = (theta_on * on - theta_off * off) / seconds
    assert on.sum() > 20 * 0.5 * seconds
    assert drift_per_s.mean() == pytest.approx(0.5, rel=0.02)
    assert drift_per_s.std() < 0.06


def test_a_recording_does_not_begin_with_a_burst() -> None:
    config = SensorConfig(width=96, height=96)
    for lux in (0.1, 0.4, 300.0):
        events, _ = run_sensor(config, still(config, lux, 20.0, 500_000), seed=6)
        early = np.count_nonzero(events["t"] <= 2_000_000) / 2.0
        late = np.count_nonzero(events["t"] > 2_000_000) / 18.0
        assert early == pytest.approx(late, rel=0.15)


def test_faint_noise_leaves_the_events_of_the_signal() -> None:
    quiet = SensorConfig(
        width=WIDTH, height=HEIGHT, noise_sigma=0.0, leak_hz=0.0, leak_hz_per_lux=0.0
    )
    clean, _ = run_sensor(quiet, moving_texture(200))
    faint, causes = run_sensor(replace(quiet, noise_sigma=1e-4), moving_texture(200))
    assert clean.size > 1000
    assert faint.size == pytest.approx(clean.size, rel=0.003)
    assert np.mean(causes == Cause.SIGNAL) > 0.99
    edges = np.arange(0, 200_001, 500)
    first, second = (np.histogram(events["t"], edges)[0] for events in (clean, faint))
    assert np.abs(first - second).sum() < 0.05 * clean.size


def test_only_a_change_of_the_light_causes_signal_events() -> None:
    """Of two still scenes with a step between them, the step alone has events of the signal."""
    config = noisy(theta_on=0.3, theta_off=0.36, noise_sigma=0.09, leak_hz=0.2)
    frames = [uniform_frame(luminance_for_lux(lux, config), config) for lux in (30.0, 100.0)]
    samples = [(t, frames[t > 1_000_000]) for t in range(0, 4_000_001, 10_000)]
    events, causes = run_sensor(config, samples)
    signal = events[causes == Cause.SIGNAL]
    assert signal.size > 3 * SIDE * SIDE
    assert signal["t"].min() > 1_000_000
    assert np.mean(signal["t"] < 1_200_000) > 0.97
    assert {Cause.SHOT, Cause.LEAK} <= set(causes)


@pytest.mark.parametrize(
    ("follower_hz", "level", "digest"),
    [
        (0.0, 0.3, "09ec3f83d99f6d0c017b67e287a00f6a6e0988b6ab476b4b33c72049321d9f0c"),
        (0.0, 100.0, "03ea2632020a4692b88e97f9fdaa21978953dbb0d2152ac10e9707a794d5e23c"),
        (590.0, 0.3, "2dfdef38e8156c40331b4e4e91807fe02665a5b6f23666e7a038ef2cc9d4e0da"),
        (590.0, 100.0, "f8c807eb0fd207c468d06cf1afd401fc24ead3e5caebbbb814d663eb36b76e6f"),
    ],
)
def test_without_noise_the_events_are_those_of_november_2026(
    follower_hz: float, level: float, digest: str
) -> None:
    """Bit for bit, with leak and hot pixels; the digests are older than the noise."""
    config = noisy(
        width=WIDTH,
        height=HEIGHT,
        theta_on=0.18,
        theta_off=0.22,
        theta_mismatch=0.035,
        bandwidth_hz_per_lux=100.0,
        bandwidth_limit_hz=3000.0,
        dark_lux=0.01,
        leak_hz=0.1,
        leak_hz_per_lux=2.4e-5,
        hot_fraction=0.02,
        follower_hz=follower_hz,
        aps=SensorConfig().aps,
    )
    events, causes = run_sensor(config, moving_texture(300, level=level))
    assert hashlib.sha256(events.tobytes() + causes.tobytes()).hexdigest() == digest


def test_the_refractory_period_is_kept_and_noise_alternates() -> None:
    config = noisy(noise_sigma=0.42, refractory_us=500)
    events, causes = run_sensor(config, still(config, 13.8, 5.0, 10_000))
    assert intervals_us(events).min() >= 500
    assert np.all(causes == Cause.SHOT)
    assert of_sensor(events, 5.0).alternation > 0.75
