"""Units of times that come without one."""

from fractions import Fraction

import pytest

from scenarios.emulate.time_unit import guess_unit


@pytest.mark.parametrize("in_names", [False, True])
@pytest.mark.parametrize(
    ("texts", "unit"),
    [
        (("0.0", "0.033", "0.067"), "s"),
        (("0.0", "0.0001", "0.0002"), "s"),
        (("0", "33.333", "66.667"), "ms"),
        (("0", "33333", "66667"), "us"),
        (("0", "1000", "2000"), "us"),
        (("0.0000e+00", "3.3333e+04", "6.6667e+04"), "us"),  # whole floats are not seconds
        (("0", "33333333", "66666667"), "ns"),
        (("1700000000.0", "1700000000.5"), "s"),
        (("1700000000000000", "1700000000000100"), "us"),
        (("1700000000000000000", "1700000000000100000"), "ns"),
    ],
)
def test_the_unit_follows_from_the_values(
    texts: tuple[str, ...], unit: str, in_names: bool
) -> None:
    values = [Fraction(text) for text in texts]
    if in_names and texts[0] == "1700000000000000":  # steps of 100 may be frame numbers
        assert guess_unit(values, in_names=True) is None
        return
    found = guess_unit(values, in_names=in_names)
    assert found is not None
    assert found[0] == unit


def test_consecutive_whole_numbers_are_frame_numbers() -> None:
    assert guess_unit([Fraction(k) for k in range(5, 9)], in_names=False) is None
    small = [Fraction(k) for k in (0, 33, 67)]
    assert guess_unit(small, in_names=True) is None
    assert guess_unit(small, in_names=False) == (
        "ms",
        "whole numbers that give 30.3 Hz; --time-unit sets another",
    )
