"""Random samples and their distributions."""

import math
from typing import Any

import numpy as np
import pytest

from scenarios.errors import ScenarioError
from scenarios.sweep.random_sample import Distribution, RandomSample, parse_distribution
from sim import VehicleKind

UNIFORM = parse_distribution("sensor.theta_on", {"uniform": [0.1, 0.5]})
LOG = parse_distribution("sensor.leak_hz", {"log_uniform": [0.1, 1000]})
WHOLE = parse_distribution("crossing.supersample", {"uniform": [2, 5]})
LOG_WHOLE = parse_distribution("sensor.refractory_us", {"log_uniform": [1, 20]})
CHOICE = parse_distribution("crossing.vehicle", {"choice": ["sedan", "van"]})


def test_numbers_follow_their_distribution() -> None:
    even = np.array(UNIFORM.draw(4000, 0))
    assert (even.min() >= 0.1, even.max() < 0.5) == (True, True)
    assert np.histogram(even, 4, (0.1, 0.5))[0] == pytest.approx(1000, abs=100)
    log = np.log10(LOG.draw(4000, 0))
    assert np.histogram(log, 4, (-1, 3))[0] == pytest.approx(1000, abs=100)


def test_whole_numbers_include_both_bounds() -> None:
    drawn = WHOLE.draw(4000, 0)
    assert all(type(value) is int for value in drawn)
    assert np.bincount(drawn)[2:] == pytest.approx(1000, abs=100)
    log = np.array(LOG_WHOLE.draw(9000, 0))
    assert (log.min(), log.max()) == (1, 20)
    assert np.mean(log < 5) == pytest.approx(math.log(5) / math.log(21), abs=0.02)


def test_a_choice_includes_every_value() -> None:
    drawn = CHOICE.draw(1000, 3)
    assert drawn.count(VehicleKind.VAN) == pytest.approx(500, abs=60)
    assert set(drawn) == {VehicleKind.SEDAN, VehicleKind.VAN}


def test_more_points_or_parameters_do_not_change_earlier_values() -> None:
    few = RandomSample((UNIFORM, CHOICE), 5, seed=2).settings()
    more = RandomSample((LOG, UNIFORM, CHOICE), 8, seed=2).settings()
    assert [{k: s[k] for k in few[0]} for s in more[:5]] == few
    assert RandomSample((UNIFORM, CHOICE), 5, seed=3).settings() != few
    assert [s["sensor.theta_on"] for s in few] != UNIFORM.draw(5, 3)


@pytest.mark.parametrize(
    ("name", "entry", "words"),
    [
        ("sensor.theta_on", 0.2, "Allowed in [sample] is {uniform = [low, high]}"),
        ("sensor.theta_on", [0.2, 0.3], "Allowed in [sample] is {uniform"),
        ("sensor.theta_on", {"normal": [0.2, 0.3]}, "Allowed in [sample] is {uniform"),
        ("sensor.theta_on", {"uniform": [0.1, 0.2], "choice": [1]}, "Choose one of these forms"),
        ("sensor.theta_on", {"uniform": [0.3, 0.1]}, "low below high"),
        ("sensor.theta_on", {"uniform": [0.3]}, "Correct the two numbers"),
        ("sensor.theta_on", {"uniform": [0.1, math.inf]}, "low below high"),
        ("sensor.theta_on", {"log_uniform": [0, 1]}, "low below high and above 0"),
        ("sensor.theta_on", {"uniform": ["a", 1]}, "is 'a'. Allowed is a number"),
        ("crossing.supersample", {"uniform": [1.5, 3]}, "is 1.5. Allowed is a whole number"),
        ("crossing.vehicle", {"uniform": ["sedan", "van"]}, "{choice = [one, another]}"),
        ("crossing.vehicle", {"choice": []}, "Write the values in square brackets"),
        ("crossing.vehicle", {"choice": ["tank"]}, "is 'tank'. Allowed is one of"),
    ],
)
def test_an_invalid_distribution_is_refused(name: str, entry: Any, words: str) -> None:
    with pytest.raises(ScenarioError) as refusal:
        parse_distribution(name, entry)
    assert str(refusal.value).startswith(f"{name} is ")
    assert words in str(refusal.value)


def test_a_distribution_is_plain_data() -> None:
    assert Distribution("sensor.theta_on", "uniform", (0.1, 0.5)) == UNIFORM
