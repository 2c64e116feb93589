"""Flies behind emulated sensors: from many events an edge to one."""

import pytest

from emulator import SensorConfig
from flybench.direction import Direction
from scenarios.pipeline.repeats import run_side_by_side
from scenarios.pipeline.run_config import RunConfig
from tests.scenarios.pipeline.drawn_samples import bar_samples

SETTLED_US = 50_000


def directions(method: str, sensor: SensorConfig) -> set[Direction]:
    """Return the directions that a fly names after 50 ms of a moving bar."""
    (run,), _ = run_side_by_side([RunConfig(sensor=sensor, method=method)], bar_samples())
    return {e.direction for e in run.estimates if e.t_us > SETTLED_US}


@pytest.mark.parametrize("refractory_us", [3, 270, 3000])
@pytest.mark.parametrize("theta", [0.15, 0.5])
def test_robust_holds_at_low_and_high_thresholds(theta: float, refractory_us: int) -> None:
    sensor = SensorConfig(theta_on=theta, theta_off=1.25 * theta, refractory_us=refractory_us)
    assert directions("robust", sensor) == {Direction.RIGHT}


def test_one_event_an_edge_is_enough_for_robust_only() -> None:
    """The surface of the paper counts only events that have a predecessor in their pixel."""
    sensor = SensorConfig(theta_on=0.42, theta_off=0.48, refractory_us=50_000)
    assert directions("robust", sensor) == {Direction.RIGHT}
    assert directions("fly", sensor) == directions("wide", sensor) == {Direction.NONE}
