"""Points that share their light, measured together and alone."""

from dataclasses import replace

import pytest

from emulator import SensorConfig
from scenarios.errors import ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.pipeline.run_config import RunConfig, flat
from scenarios.pipeline.running import Stopwatch, make_crossing, make_detector, note, run_steps
from scenarios.pipeline.scoring import Track, judge
from scenarios.pipeline.summary import EventTally, truth_summary
from scenarios.sweep.code import code_digest
from scenarios.sweep.measure import MOST_TOGETHER, Failure, Results, Task, make_tasks, measure
from sim import CrossingConfig

COARSE = CrossingConfig(omega_rad_s=3.0, step_px=8.0, supersample=1, lead_s=0.05)
SMALL = SensorConfig(width=96, height=64)
FLY = RunConfig(COARSE, SMALL, seed=3)
CONFIGS = (
    FLY,
    replace(FLY, seed=4),
    replace(FLY, method="plane-fit", fly=None),
    replace(FLY, sensor=replace(SMALL, theta_on=0.3)),
)


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> CacheOptions:
    return CacheOptions(cache=tmp_path_factory.mktemp("light"))


def task(*configs: RunConfig, cache: CacheOptions) -> Task:
    return Task(configs, cache, code_digest(), alone=True)


def alone(config: RunConfig, cache: CacheOptions) -> Results:
    """As `flybench run` does it."""
    crossing, detector = make_crossing(config, cache.open()), make_detector(config)
    tally, track, said = EventTally(), Track(), []
    for step in run_steps(config, crossing, detector, Stopwatch()):
        tally.add(step.output)
        note(track, step.sample.truth)
        said += step.estimates
    truth = truth_summary(config, crossing, track.in_view_us)
    judged = judge(said, config.crossing.direction, track.in_view_us, track)
    return dict(flat({"truth": truth, "events": tally.summary(), "detector": judged}))


def test_every_point_is_as_it_would_be_alone(cache: CacheOptions) -> None:
    together = measure(task(*CONFIGS, cache=cache))
    assert together == [alone(config, cache) for config in CONFIGS]
    counts = [result["events.count"] for result in together if not isinstance(result, Failure)]
    assert counts[0] == counts[2]
    assert len(set(counts)) == 3
    assert together[0]["detector.direction"] == "right"  # type: ignore[index]


def test_what_fails_fails_alone(cache: CacheOptions) -> None:
    bee = replace(FLY, method="tests.scenarios.sweep.cheap:Bee", fly=None)
    good, bad = measure(task(FLY, bee, cache=cache))
    assert good == measure(task(FLY, cache=cache))[0]
    assert isinstance(bad, Failure)
    assert bad.reason.startswith("RuntimeError: no nectar (cheap.py, line ")


def test_other_code_is_refused(cache: CacheOptions) -> None:
    with pytest.raises(ScenarioError, match=r"runs another version of flybench .* start anew"):
        measure(Task((FLY,), cache, code="of last year"))


def test_tasks_share_light_and_begin_with_one_of_each() -> None:
    night = replace(FLY, crossing=replace(COARSE, street_seed=1))
    wide = replace(FLY, sensor=SensorConfig(width=97, height=64))
    configs = [replace(c, seed=n) for n in range(MOST_TOGETHER + 1) for c in (FLY, night, wide)]
    tasks = make_tasks(configs, CacheOptions())
    assert [len(task.configs) for task in tasks] == [MOST_TOGETHER] * 3 + [1] * 3
    assert sorted(c.name for task in tasks for c in task.configs) == sorted(c.name for c in configs)
    for task in tasks:
        assert len({(c.crossing, c.sensor.width) for c in task.configs}) == 1


def test_a_sweep_of_nothing_has_no_task() -> None:
    assert make_tasks([], CacheOptions()) == []
