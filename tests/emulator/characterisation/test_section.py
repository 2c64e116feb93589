"""Sections of the data sheet."""

import numpy as np
import pytest

from emulator.characterisation.section import Published, Quantity, Section, series


def test_the_first_of_several_rows_with_one_name_counts() -> None:
    first, second = (Quantity("a", "Hz", 3.0, Published(p, "x")) for p in (3.0, 6.0))
    assert Section("", "", [first, second]).figures == {"a": first}


def test_the_difference_is_relative() -> None:
    assert Quantity("a", "Hz", 3.3, Published(3.0, "x")).difference == pytest.approx(0.1)
    assert Quantity("a", "Hz", None, Published(3.0, "x")).difference is None
    assert Quantity("a", "Hz", 3.3).difference is None
    assert Quantity("a", "Hz", 3.3, Published(0.0, "x")).difference is None


def test_nan_in_a_series_is_a_gap() -> None:
    gapped = series("a", [1, 2], [3.0, np.nan])
    assert gapped.y.dtype == np.float64
    assert np.isnan(gapped.y).tolist() == [False, True]
