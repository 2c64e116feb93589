"""ROC curves of filters."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from detector.denoise import FILTERS
from scenarios.denoise.roc import _curve, _with_ends, kept_shares, measure_roc
from tests.detector.denoise.test_filters import edge_and_noise


@given(st.lists(st.tuples(st.integers(-3, 3), st.booleans()), min_size=2, max_size=30))
def test_the_area_is_the_probability_that_signal_scores_higher_than_noise(
    pairs: list[tuple[int, bool]],
) -> None:
    scores, labels = (np.array(column) for column in zip(*pairs, strict=True))
    if labels.all() or not labels.any():
        return
    noise, signal = _curve(scores.astype(np.float32), labels)
    differences = scores[labels][:, None] - scores[~labels][None, :]
    expected = (differences > 0).mean() + 0.5 * (differences == 0).mean()
    assert np.trapezoid(signal, noise) == pytest.approx(expected)
    assert (noise[0], signal[0], noise[-1], signal[-1]) == (0, 0, 1, 1)
    assert (np.diff(noise) >= 0).all()
    assert (np.diff(signal) >= 0).all()


def test_a_curve_of_points_runs_from_corner_to_corner() -> None:
    noise, signal = _with_ends([(0.9, 0.3), (0.5, 0.1)])
    assert noise.tolist() == [0, 0.1, 0.3, 1]
    assert signal.tolist() == [0, 0.5, 0.9, 1]


@pytest.mark.parametrize("name", FILTERS)
def test_the_default_threshold_lies_on_the_curve(name: str) -> None:
    events, is_signal = edge_and_noise()
    roc = measure_roc(name, events, is_signal, width=346, height=260)
    made = FILTERS[name](width=346, height=260)
    signal, noise = kept_shares(made.scores(events) >= made.threshold, is_signal)
    assert roc.at_default == (signal, noise)
    assert np.interp(noise, roc.kept_noise, roc.kept_signal) == pytest.approx(signal, abs=0.03)
    assert roc.area > 0.9
    assert len(roc.kept_noise) <= 200
