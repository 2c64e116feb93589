"""Names, types and ranges of the parameters that a sweep can set."""

from dataclasses import replace
from typing import Any

import pytest

from detector.fly.config import FlyConfig
from emulator import ReadoutKind, SensorConfig, preset
from flybench.direction import Direction
from scenarios.errors import ScenarioError
from scenarios.pipeline.run_config import RunConfig
from scenarios.sweep.parameters import (
    PRESET,
    allowed,
    check_name,
    converted,
    make_config,
    parameter_types,
)
from sim import Lighting


def test_every_parameter_of_a_run_and_the_preset_are_known() -> None:
    assert set(parameter_types()) == set(RunConfig().parameters()) | {PRESET}
    assert all(allowed(kind) for kind in parameter_types().values())


def test_the_defaults_have_their_types_and_make_the_default_run() -> None:
    defaults = RunConfig().parameters()
    given = {n: list(v) if isinstance(v, tuple) else v for n, v in defaults.items()}
    typed = {name: converted(name, value) for name, value in given.items()}
    assert typed == defaults
    assert make_config(typed).parameters() == defaults
    assert make_config({}) == RunConfig()


@pytest.mark.parametrize(
    ("name", "value", "typed"),
    [
        ("crossing.direction", "left", Direction.LEFT),
        ("crossing.omega_rad_s", 2, 2.0),
        ("sensor.aps.noise", False, False),
        ("sensor.aps.shutter", "rolling", "rolling"),
        ("sensor.readout.kind", "scan", ReadoutKind.SCAN),
        ("sensor.readout.limit_hz", 2_000_000, 2e6),
        ("fly.further_delays_us", [100_000], (100_000,)),
        ("crossing.distance_m", 7, 7.0),
    ],
)
def test_a_value_is_converted_to_the_type_of_its_parameter(
    name: str, value: Any, typed: Any
) -> None:
    got = converted(name, value)
    assert got == typed
    assert type(got) is type(typed)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("crossing.omega_rad_s", "fast", "is 'fast'. Allowed is a number"),
        ("crossing.omega_rad_s", True, "is True. Allowed is a number"),
        ("crossing.supersample", 1.5, "is 1.5. Allowed is a whole number"),
        ("crossing.direction", "ight", 'is \'ight\'. Allowed is one of "right", "left", "up"'),
        ("crossing.distance_m", "far", "is 'far'. Allowed is a number"),
        ("sensor.aps.noise", 1, "is 1. Allowed is true or false"),
        ("sensor.aps.shutter", "slow", 'is \'slow\'. Allowed is one of "global", "rolling"'),
        ("sensor.preset", "dvs129", "is 'dvs129'. Allowed is one of \"davis346\""),
        ("fly.further_delays_us", 3, "is 3. Allowed is a list of whole numbers"),
        ("method", 3, "is 3. Allowed is text in quotes"),
        ("seed", [1], "is [1]. Allowed is a whole number"),
    ],
)
def test_a_value_of_a_wrong_type_is_refused(name: str, value: Any, words: str) -> None:
    with pytest.raises(ScenarioError) as refusal:
        converted(name, value)
    assert f"{name} {words}" in str(refusal.value)


@pytest.mark.parametrize(
    ("name", "similar"),
    [
        ("crossing.omega", "crossing.omega_rad_s"),
        ("omega_rad_s", "crossing.omega_rad_s"),
        ("sensor.wind_grade", "crossing.distractors.wind_grade"),
        ("crossing.directon", "crossing.direction"),
        ("methods", "method"),
        ("wind", "crossing.distractors.wind_grade"),
    ],
)
def test_an_unknown_name_is_refused_with_similar_ones(name: str, similar: str) -> None:
    with pytest.raises(ScenarioError, match=f"no parameter {name}. Similar names are .*{similar}"):
        check_name(name)


def test_a_name_without_similar_ones_is_refused() -> None:
    with pytest.raises(
        ScenarioError, match=r"no parameter zzz\. No name is similar\. .*--parameters"
    ):
        check_name("zzz")


def test_the_preset_gives_the_defaults_of_the_sensor() -> None:
    config = make_config({PRESET: "dvs128", "sensor.theta_on": 0.3, "sensor.aps.noise": False})
    dvs = preset("dvs128")
    assert config.sensor == replace(dvs, theta_on=0.3, aps=replace(dvs.aps, noise=False))
    assert make_config({}).sensor == SensorConfig()


def test_the_method_gives_the_defaults_of_the_fly() -> None:
    wide = FlyConfig.preset("wide")
    assert make_config({"method": "wide", "fly.alpha": 0.7}).fly == replace(wide, alpha=0.7)
    assert make_config({"method": "plane-fit"}).fly is None
    assert make_config({"crossing.lighting": Lighting.NIGHT}).crossing.distance == 7.79


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"crossing.omega_rad_s": -1.0}, "crossing.omega_rad_s is -1.0. Allowed is"),
        (
            {"crossing.distractors.wind_grade": 9},
            "crossing.distractors.wind_grade is 9. Allowed is",
        ),
        ({"sensor.theta_on": 0.0}, "sensor.theta_on is 0.0. Allowed is a number from 0.01"),
        ({"sensor.aps.target_dn": 700.0}, "sensor.aps.target_dn is 700.0. Allowed is"),
        ({"fly.alpha": 2.0}, "fly.alpha is 2.0. Allowed is"),
        ({"seed": -1}, "seed is -1. Allowed is a whole number from 0 to"),
        ({"sensor.leak_hz": 900.0, "sensor.temperature_c": 90.0}, "sensor: warm_leak_hz is"),
        (
            {"method": "plane-fit", "fly.alpha": 0.4},
            "The method is plane-fit, but parameters of the fly",
        ),
    ],
)
def test_a_value_out_of_range_is_refused_with_its_dotted_name(
    settings: dict[str, Any], words: str
) -> None:
    with pytest.raises(ScenarioError) as refusal:
        make_config(settings)
    assert str(refusal.value).startswith(words)


def test_a_crossing_has_no_direction_none() -> None:
    words = allowed(parameter_types()["crossing.direction"])
    assert words == 'one of "right", "left", "up", "down"'
