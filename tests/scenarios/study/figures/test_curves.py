import math

import numpy as np
import pytest

from scenarios.pipeline.registry import FLY
from scenarios.study.figures.curves import Curve, curve, mean_curve
from tests.scenarios.study.synthetic_results import make_run


def make_curve(times: list[float], values: list[float]) -> Curve:
    return Curve(np.array(times), np.array(values))


def test_a_curve_has_a_point_for_each_estimate() -> None:
    run = make_run(FLY, 0)
    found = curve(run, lambda e: e.hs)
    assert found.t_us.tolist() == [e.t_us for e in run.estimates]
    assert found.values.tolist() == [e.hs for e in run.estimates]


def test_the_mean_leaves_out_nan() -> None:
    mean = mean_curve(
        [make_curve([1, 2, 3], [1, math.nan, math.nan]), make_curve([1, 2, 3], [3, 5, math.nan])]
    )
    assert mean.t_us.tolist() == [1, 2, 3]
    assert mean.values[:2].tolist() == [2, 5]
    assert math.isnan(mean.values[2])


def test_the_mean_at_different_times_is_interpolated_where_all_curves_overlap() -> None:
    mean = mean_curve([make_curve([0, 10, 20], [0, 10, 20]), make_curve([5, 15, 25], [1, 1, 1])])
    assert mean.t_us.tolist() == [5, 10, 15, 20]
    assert mean.values == pytest.approx([3, 5.5, 8, 10.5])


@pytest.mark.parametrize("curves", [[], [make_curve([], []), make_curve([1], [2])]])
def test_there_is_no_mean_without_estimates_of_every_seed(curves: list[Curve]) -> None:
    assert mean_curve(curves).t_us.size == 0
