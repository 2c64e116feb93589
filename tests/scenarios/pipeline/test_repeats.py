"""One sequence shown to many sensors."""

from emulator import EventSensor, SensorConfig
from scenarios.pipeline.repeats import run_repeats
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_feed
from tests.scenarios.pipeline.drawn_samples import PERIOD_US, SAMPLES, bar_samples


def test_every_seed_gives_the_same_estimates_as_alone() -> None:
    config = RunConfig(sensor=SensorConfig())
    together, track = run_repeats(config, bar_samples(), (3, 8))
    assert track.in_view_us == (0, (SAMPLES - 1) * PERIOD_US)
    assert track.box_px(15_000) == (20, 100, 80, 160)
    for seed, estimates in zip((3, 8), together, strict=True):
        sensor, feed, alone = EventSensor(config.sensor, seed=seed), make_feed(config), []
        for sample in bar_samples():
            events = sensor.step(sample.t_us, sample.luminance).events
            alone += feed.feed(events, until_us=sample.t_us + 1)
        assert estimates == alone
    assert together[0] != together[1]


def test_progress_is_reported() -> None:
    reported: list[int] = []
    run_repeats(RunConfig(), bar_samples(), (0,), reported.append)
    assert reported == [PERIOD_US * k for k in range(SAMPLES)]
