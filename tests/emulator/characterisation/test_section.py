"""Figures beside published ones."""

import numpy as np
import pytest

from emulator.characterisation.section import Published, Quantity, series


def test_difference_is_relative() -> None:
    assert Quantity("a", "Hz", 3.3, Published(3.0, "x")).difference == pytest.approx(0.1)
    assert Quantity("a", "Hz", None, Published(3.0, "x")).difference is None
    assert Quantity("a", "Hz", 3.3).difference is None
    assert Quantity("a", "Hz", 3.3, Published(0.0, "x")).difference is None


def test_series_turn_gaps_into_nan() -> None:
    made = series("a", [1, 2], [3.0, np.nan])
    assert made.y.dtype == np.float64
    assert np.isnan(made.y).tolist() == [False, True]
