"""Random samples."""

import math
from typing import Any

import numpy as np
import pytest

from scenarios.errors import ScenarioError
from scenarios.sweep.draws import Draw, Sample, parse_draw
from sim import VehicleKind

UNIFORM = parse_draw("sensor.theta_on", {"uniform": [0.1, 0.5]})
LOG = parse_draw("sensor.shot_noise_scale", {"log_uniform": [0.1, 1000]})
WHOLE = parse_draw("crossing.supersample", {"uniform": [2, 5]})
LOG_WHOLE = parse_draw("sensor.refractory_us", {"log_uniform": [1, 20]})
CHOICE = parse_draw("crossing.vehicle", {"choice": ["sedan", "van"]})


def test_numbers_follow_their_law() -> None:
    even = np.array(UNIFORM.draw(4000, 0))
    assert (even.min() >= 0.1, even.max() < 0.5) == (True, True)
    assert np.histogram(even, 4, (0.1, 0.5))[0] == pytest.approx(1000, abs=100)
    log = np.log10(LOG.draw(4000, 0))
    assert np.histogram(log, 4, (-1, 3))[0] == pytest.approx(1000, abs=100)


def test_whole_numbers_reach_both_bounds_evenly() -> None:
    drawn = WHOLE.draw(4000, 0)
    assert all(type(value) is int for value in drawn)
    assert np.bincount(drawn)[2:] == pytest.approx(1000, abs=100)
    log = np.array(LOG_WHOLE.draw(9000, 0))
    assert (log.min(), log.max()) == (1, 20)
    assert np.mean(log < 5) == pytest.approx(math.log(5) / math.log(21), abs=0.02)


def test_a_choice_takes_all_of_them() -> None:
    drawn = CHOICE.draw(1000, 3)
    assert drawn.count(VehicleKind.VAN) == pytest.approx(500, abs=60)
    assert set(drawn) == {VehicleKind.SEDAN, VehicleKind.VAN}


def test_a_sample_repeats_and_grows_by_its_end_alone() -> None:
    few = Sample((UNIFORM, CHOICE), 5, seed=2).settings()
    more = Sample((LOG, UNIFORM, CHOICE), 8, seed=2).settings()
    assert [{k: s[k] for k in few[0]} for s in more[:5]] == few
    assert Sample((UNIFORM, CHOICE), 5, seed=3).settings() != few
    assert [s["sensor.theta_on"] for s in few] != UNIFORM.draw(5, 3)


@pytest.mark.parametrize(
    ("name", "law", "words"),
    [
        ("sensor.theta_on", 0.2, "allowed in [sample] is {uniform = [low, high]}"),
        ("sensor.theta_on", [0.2, 0.3], "allowed in [sample] is {uniform"),
        ("sensor.theta_on", {"normal": [0.2, 0.3]}, "allowed in [sample] is {uniform"),
        ("sensor.theta_on", {"uniform": [0.1, 0.2], "choice": [1]}, "give one of them"),
        ("sensor.theta_on", {"uniform": [0.3, 0.1]}, "low below high"),
        ("sensor.theta_on", {"uniform": [0.3]}, "give two such numbers"),
        ("sensor.theta_on", {"uniform": [0.1, math.inf]}, "low below high"),
        ("sensor.theta_on", {"log_uniform": [0, 1]}, "low below high and above 0"),
        ("sensor.theta_on", {"uniform": ["a", 1]}, "is 'a'; allowed is a number"),
        ("crossing.supersample", {"uniform": [1.5, 3]}, "is 1.5; allowed is a whole number"),
        ("crossing.vehicle", {"uniform": ["sedan", "van"]}, "{choice = [one, another]}"),
        ("crossing.vehicle", {"choice": []}, "put values in the brackets"),
        ("crossing.vehicle", {"choice": ["tank"]}, "is 'tank'; allowed is one of"),
    ],
)
def test_what_is_no_law_is_refused(name: str, law: Any, words: str) -> None:
    with pytest.raises(ScenarioError) as refusal:
        parse_draw(name, law)
    assert str(refusal.value).startswith(f"{name} is ")
    assert words in str(refusal.value)


def test_a_draw_is_plain_data() -> None:
    assert Draw("sensor.theta_on", "uniform", (0.1, 0.5)) == UNIFORM
