"""Points that share a rendered sequence, measured together and one by one."""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from emulator import SensorConfig
from scenarios.errors import ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.pipeline.run_config import RunConfig, flatten
from scenarios.pipeline.running import Stopwatch, add_truth, make_crossing, make_feed, run_steps
from scenarios.pipeline.scoring import TargetTrack, score_estimates
from scenarios.pipeline.summary import EventTally, truth_summary
from scenarios.sweep.measure import (
    MAX_TASK_POINTS,
    Failure,
    Results,
    Task,
    make_tasks,
    measure_task,
)
from scenarios.sweep.point_key import code_digest
from sim import CrossingConfig
from sim.render.kept_renderer import release_renderer

COARSE = CrossingConfig(omega_rad_s=3.0, step_px=8.0, supersample=1, lead_s=0.05)
SMALL = SensorConfig(width=96, height=64)
FLY = RunConfig(COARSE, SMALL, seed=3)
CONFIGS = (
    FLY,
    replace(FLY, seed=4),
    replace(FLY, method="plane-fit", fly=None),
    replace(FLY, sensor=replace(SMALL, theta_on=0.3)),
)


@pytest.fixture(scope="module", autouse=True)
def no_renderer_left() -> Iterator[None]:
    yield
    release_renderer()


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> CacheOptions:
    return CacheOptions(cache=tmp_path_factory.mktemp("cache"))


def task(*configs: RunConfig, cache: CacheOptions) -> Task:
    return Task(configs, cache, code_digest(), use_all_cores=True)


def run_alone(config: RunConfig, cache: CacheOptions) -> Results:
    """Run one point as `flybench run` does."""
    crossing, feed = make_crossing(config, cache.open()), make_feed(config)
    tally, track, estimates = EventTally(), TargetTrack(), []
    for step in run_steps(config, crossing, feed, Stopwatch()):
        tally.add(step.output)
        add_truth(track, step.sample.truth)
        estimates += step.estimates
    truth = truth_summary(config, crossing, track.in_view_us)
    scores = score_estimates(estimates, config.crossing.direction, track.in_view_us, track)
    return dict(flatten({"truth": truth, "events": tally.summary(), "detector": scores}))


def test_every_point_has_the_same_results_as_alone(cache: CacheOptions) -> None:
    together = measure_task(task(*CONFIGS, cache=cache))
    assert together == [run_alone(config, cache) for config in CONFIGS]
    counts = [result["events.count"] for result in together if not isinstance(result, Failure)]
    assert counts[0] == counts[2]
    assert len(set(counts)) == 3
    assert together[0]["detector.direction"] == "right"  # type: ignore[index]


def test_one_failing_point_does_not_affect_the_others(cache: CacheOptions) -> None:
    failing = replace(FLY, method="tests.scenarios.sweep.quick_sweep:FailingDetector", fly=None)
    good, bad = measure_task(task(FLY, failing, cache=cache))
    assert good == measure_task(task(FLY, cache=cache))[0]
    assert isinstance(bad, Failure)
    assert bad.reason.startswith("tests.scenarios.sweep.quick_sweep:FailingDetector: ")
    assert "RuntimeError: no nectar (quick_sweep.py, line " in bad.reason


def test_a_worker_with_other_code_is_refused(cache: CacheOptions) -> None:
    with pytest.raises(ScenarioError, match=r"runs another version of flybench .* start again"):
        measure_task(Task((FLY,), cache, code="of last year"))


def test_a_task_has_one_sequence_and_every_sequence_starts_early() -> None:
    other_street = replace(FLY, crossing=replace(COARSE, street_seed=1))
    wide = replace(FLY, sensor=SensorConfig(width=97, height=64))
    configs = [
        replace(c, seed=n) for n in range(MAX_TASK_POINTS + 1) for c in (FLY, other_street, wide)
    ]
    tasks = make_tasks(configs, CacheOptions())
    assert [len(task.configs) for task in tasks] == [MAX_TASK_POINTS] * 3 + [1] * 3
    assert sorted(c.name for task in tasks for c in task.configs) == sorted(c.name for c in configs)
    for task in tasks:
        assert len({(c.crossing, c.sensor.width) for c in task.configs}) == 1


def test_no_points_make_no_tasks() -> None:
    assert make_tasks([], CacheOptions()) == []
