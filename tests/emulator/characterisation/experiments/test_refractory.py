"""The refractory period is recovered from the intervals on ramps."""

from dataclasses import replace

import pytest

from emulator import SensorConfig
from emulator.characterisation.experiments.refractory import measure, measure_refractory
from tests.emulator.characterisation.plain_sensor import PLAIN


@pytest.mark.parametrize("refractory_us", [0, 3, 40, 500])
def test_the_period_is_recovered(refractory_us: int) -> None:
    config = replace(PLAIN, refractory_us=refractory_us)
    found = measure_refractory(config, seed=1)
    assert found.refractory_us == pytest.approx(refractory_us, abs=0.3, rel=0.02)
    assert found.theta_on == pytest.approx(0.18, rel=0.1)
    assert found.shortest_us is not None
    assert found.shortest_us >= refractory_us


def test_section_of_the_default_sensor() -> None:
    period, shortest, theta = measure(SensorConfig(), seed=1).quantities
    assert period.difference == pytest.approx(0.0, abs=0.1)
    assert shortest.measured is not None
    assert theta.measured is not None


def test_a_follower_does_not_hide_the_period() -> None:
    config = replace(PLAIN, refractory_us=40, follower_hz=600.0)
    found = measure_refractory(config, seed=1)
    assert found.refractory_us == pytest.approx(40.0, rel=0.05)
    assert found.theta_on == pytest.approx(0.18, rel=0.1)
