"""The configuration of a run."""

import pytest

from detector.fly.config import FlyConfig
from scenarios.errors import ScenarioError
from scenarios.pipeline.run_config import RunConfig


def test_only_the_fly_has_parameters_of_the_fly() -> None:
    with pytest.raises(ScenarioError, match="but parameters of the fly are given"):
        RunConfig(method="my_detector:Mine", fly=FlyConfig())
    assert RunConfig(method="wide").fly == FlyConfig.preset("wide")
    assert "fly.tau_us" in RunConfig().parameters()
    for method in ("plane-fit", "my_detector:Mine"):
        assert RunConfig(method=method).fly is None
        assert RunConfig(method=method).parameters()["fly"] is None


def test_the_name_contains_the_method() -> None:
    assert RunConfig().name.endswith("seed0")
    assert RunConfig(method="wide").name.endswith("seed0_wide")
    assert ":" not in RunConfig(method="my_detector:Mine").name


def test_a_seed_out_of_range_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"seed is -1\. Allowed is a whole number from 0 to"):
        RunConfig(seed=-1)
