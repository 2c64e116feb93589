import math

import numpy as np
import pytest

from scenarios.pipeline.registry import FLY
from scenarios.study.figures.curves import Curve, curve, mean_curve
from tests.scenarios.study.hand_made import a_run


def made(times: list[float], values: list[float]) -> Curve:
    return Curve(np.array(times), np.array(values))


def test_a_run_becomes_a_curve() -> None:
    run = a_run(FLY, 0)
    found = curve(run, lambda e: e.hs)
    assert found.t_us.tolist() == [e.t_us for e in run.estimates]
    assert found.values.tolist() == [e.hs for e in run.estimates]


def test_mean_at_common_times_leaves_out_what_is_no_number() -> None:
    mean = mean_curve([made([1, 2, 3], [1, math.nan, math.nan]), made([1, 2, 3], [3, 5, math.nan])])
    assert mean.t_us.tolist() == [1, 2, 3]
    assert mean.values[:2].tolist() == [2, 5]
    assert math.isnan(mean.values[2])


def test_mean_of_other_times_goes_straight_between_and_covers_what_all_cover() -> None:
    mean = mean_curve([made([0, 10, 20], [0, 10, 20]), made([5, 15, 25], [1, 1, 1])])
    assert mean.t_us.tolist() == [5, 10, 15, 20]
    assert mean.values == pytest.approx([3, 5.5, 8, 10.5])


@pytest.mark.parametrize("curves", [[], [made([], []), made([1], [2])]])
def test_no_curve_without_estimates(curves: list[Curve]) -> None:
    assert mean_curve(curves).t_us.size == 0
