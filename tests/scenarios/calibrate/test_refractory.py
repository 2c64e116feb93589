"""The edge of the histogram of intervals, on intervals that are drawn from a known law."""

import numpy as np
import pytest

from scenarios.calibrate.fits.refractory import fit_edge


def intervals(edge_us: float, exponent: float, width_us: float, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    beyond = width_us * rng.random(5000) ** (1.0 / (exponent + 1.0))
    slow = rng.exponential(50_000.0, 5000) + edge_us
    return np.sort(np.rint(np.concatenate([edge_us + beyond, slow])))


@pytest.mark.parametrize(("edge_us", "exponent"), [(270.0, 0.0), (270.0, 1.0), (1000.0, 0.5)])
def test_the_edge_is_found(edge_us: float, exponent: float) -> None:
    found = fit_edge(intervals(edge_us, exponent, edge_us))
    assert found is not None
    assert found.edge_us == pytest.approx(edge_us, rel=0.03)
    assert found.low_us <= edge_us * 1.01
    assert found.limit_us < 1.5 * edge_us


def test_a_few_outliers_do_not_move_the_edge() -> None:
    drawn = np.sort(np.concatenate([intervals(270.0, 0.5, 270.0), [20.0, 60.0, 130.0]]))
    found = fit_edge(drawn)
    assert found is not None
    assert found.edge_us == pytest.approx(270.0, rel=0.04)


def test_intervals_of_slow_light_do_not_crowd_at_an_edge() -> None:
    found = fit_edge(intervals(300.0, 3.0, 6000.0))
    assert found is not None
    assert found.limit_us > 1.5 * found.edge_us


def test_few_intervals_tell_nothing() -> None:
    assert fit_edge(np.arange(100.0)) is None
