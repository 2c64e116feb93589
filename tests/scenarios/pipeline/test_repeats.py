"""One light, many sensors."""

from collections.abc import Iterator

import numpy as np

from emulator import EventSensor, SensorConfig
from scenarios.pipeline.feeding import feed
from scenarios.pipeline.repeats import run_repeats
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_detector
from sim import Crossing, CrossingConfig, Sample
from sim.truth.probe import TruthProbe
from tests.sim.seen import target_on

CROSSING = Crossing(CrossingConfig())
WITNESS = TruthProbe(CROSSING.scene, CROSSING.intrinsics)


def samples() -> Iterator[Sample]:
    """A bright bar that goes right in 150 ms, drawn."""
    for k in range(100):
        light = np.full((260, 346), 100.0, np.float32)
        mask = np.zeros((260, 346), np.bool_)
        mask[100:160, 2 * k : 2 * k + 60] = True
        light[mask] = 300.0
        t_us = 1_500 * k
        truth = WITNESS.at(t_us, CROSSING.seconds(t_us), target_on(mask, CROSSING.scene))
        yield Sample(t_us, light, truth, changed=(0, 0, 346, 260))


def test_every_seed_sees_what_it_would_see_alone() -> None:
    config = RunConfig(sensor=SensorConfig())
    together, track = run_repeats(config, samples(), (3, 8))
    assert track.in_view_us == (0, 99 * 1_500)
    assert track.box_px(15_000) == (20, 100, 80, 160)
    for seed, said in zip((3, 8), together, strict=True):
        sensor, detector, alone = EventSensor(config.sensor, seed=seed), make_detector(config), []
        for sample in samples():
            events = sensor.step(sample.t_us, sample.luminance).events
            alone += feed(detector, events, until_us=sample.t_us + 1)
        assert said == alone
    assert together[0] != together[1]


def test_progress_is_told() -> None:
    told: list[int] = []
    run_repeats(RunConfig(), samples(), (0,), told.append)
    assert told == [1_500 * k for k in range(100)]
