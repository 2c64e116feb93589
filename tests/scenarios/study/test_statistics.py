import pytest

from scenarios.study.statistics import (
    Interval,
    by_method_and_lighting,
    distinct,
    interval_of,
    mean_interval,
    seed_means,
    select,
)


def test_the_interval_uses_students_t() -> None:
    found = mean_interval([1.0, 2.0, 3.0, 4.0, 5.0])
    assert found is not None
    # t with 4 degrees of freedom at 97.5 % is 2.776; s = √2.5
    half = 2.776 * 2.5**0.5 / 5**0.5
    assert (found.mean, found.number) == (3.0, 5)
    assert (found.low, found.high) == pytest.approx((3.0 - half, 3.0 + half), abs=1e-3)


def test_missing_values_are_left_out_and_a_single_one_has_no_width() -> None:
    assert mean_interval([None, 2.0]) == Interval(2.0, 2.0, 2.0, 1)
    assert mean_interval([None, None]) is None
    assert mean_interval([]) is None


def test_the_interval_of_a_share_is_clipped_to_0_and_1() -> None:
    found = mean_interval([1.0, 1.0, 0.9], is_share=True)
    assert found is not None
    assert found.high == 1.0
    found = mean_interval([0.0, 0.1, 0.0], is_share=True)
    assert found is not None
    assert found.low == 0.0


ROWS = [
    {"method": "fly", "lighting": "day", "sequence": "a", "seed": 0, "accuracy": 1.0},
    {"method": "fly", "lighting": "day", "sequence": "b", "seed": 0, "accuracy": 0.8},
    {"method": "fly", "lighting": "day", "sequence": "a", "seed": 1, "accuracy": None},
    {"method": "fly", "lighting": "day", "sequence": "b", "seed": 1, "accuracy": 0.5},
    {"method": "bee", "lighting": "night", "sequence": "c", "seed": 0, "accuracy": None},
]


def test_a_seed_counts_once_however_many_sequences_it_has() -> None:
    assert seed_means(select(ROWS, method="fly"), "accuracy") == [0.9, 0.5]
    found = interval_of(select(ROWS, method="fly"), "accuracy")
    assert found is not None
    assert found.mean == pytest.approx(0.7)
    assert found.number == 2


def test_intervals_by_method_and_lighting() -> None:
    found = by_method_and_lighting(ROWS, ["accuracy"])
    assert list(found) == ["fly", "bee"]
    assert list(found["fly"]) == ["day"]
    assert found["bee"] == {"night": {"accuracy": None}}
    assert distinct(ROWS, "seed") == [0, 1]
