"""Statistics of an envelope."""

import numpy as np

from scenarios.envelope.table import (
    CORRECT,
    at_base_point,
    levels,
    mean_by_cell,
    operating_range,
    worst_level,
)
from tests.scenarios.envelope.made_up_rows import made_up_row

SPEEDS = (30.0, 60.0, 120.0, 240.0)


def test_numeric_levels_are_sorted_and_names_are_not() -> None:
    rows = [made_up_row(speed_px_s=v, background=b) for v, b in ((60.0, "wind"), (30.0, "still"))]
    assert levels(rows, "speed_px_s") == [30, 60]
    assert levels(rows, "background") == ["wind", "still"]


def test_all_factors_except_the_free_ones_are_at_the_base_point() -> None:
    rows = [made_up_row(speed_px_s=v, contrast=c, noise_hz=n)
            for v in (30.0, 350.0) for c in (0.1, 0.8) for n in (1.0, 5.0)]  # fmt: skip
    kept = at_base_point(rows, ("speed_px_s", "contrast"))
    assert len(kept) == 4
    assert {r["noise_hz"] for r in kept} == {1.0}


def test_the_first_level_replaces_an_unmeasured_base_level() -> None:
    rows = [made_up_row(noise_hz=n) for n in (7.0, 9.0)]
    assert [r["noise_hz"] for r in at_base_point(rows, ())] == [7.0]


def test_a_cell_is_the_mean_of_its_rows_and_nan_without_steps() -> None:
    rows = [
        made_up_row(speed_px_s=30.0, noise_hz=0.0, correct=0.5),
        made_up_row(speed_px_s=30.0, noise_hz=0.0, correct=0.7, seed=1),
        made_up_row(speed_px_s=30.0, noise_hz=0.0, correct=None, seed=2),
        made_up_row(speed_px_s=60.0, noise_hz=0.0, correct=1.0),
        made_up_row(speed_px_s=60.0, noise_hz=5.0, correct=None),
    ]
    found = mean_by_cell(rows, "speed_px_s", "noise_hz", CORRECT)
    np.testing.assert_allclose(found, [[0.6, 1.0], [np.nan, np.nan]])


def test_the_worst_level_is_the_lowest_mean() -> None:
    rows = [made_up_row(direction=d, correct=r) for d, r in (("right", 0.9), ("up", 0.4))]
    np.testing.assert_allclose(
        worst_level(rows, "speed_px_s", "noise_hz", "direction", CORRECT), [[0.4]]
    )


def test_the_operating_range_is_the_longest_run_of_speeds() -> None:
    shares = {30.0: 0.96, 60.0: 0.5, 120.0: 0.95, 240.0: 1.0}
    assert operating_range([made_up_row(speed_px_s=v, correct=s) for v, s in shares.items()]) == (
        120,
        240,
    )
    assert operating_range([made_up_row(speed_px_s=v, correct=0.9) for v in SPEEDS]) is None
    assert operating_range([made_up_row(speed_px_s=v, correct=None) for v in SPEEDS]) is None


def test_rows_of_one_speed_are_averaged() -> None:
    rows = [made_up_row(speed_px_s=60.0, correct=r, seed=k) for k, r in enumerate((0.9, 1.0))]
    assert operating_range(rows) == (60, 60)
