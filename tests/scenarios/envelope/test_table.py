import numpy as np

from scenarios.envelope.table import RIGHT, at_base, levels, means, range_that_holds, worst
from tests.scenarios.envelope.rows import row

SPEEDS = (30.0, 60.0, 120.0, 240.0)


def test_numbers_are_sorted_and_names_are_not() -> None:
    rows = [row(speed_px_s=v, background=b) for v, b in ((60.0, "wind"), (30.0, "still"))]
    assert levels(rows, "speed_px_s") == [30, 60]
    assert levels(rows, "background") == ["wind", "still"]


def test_all_but_the_free_factors_stay_at_the_base_point() -> None:
    rows = [row(speed_px_s=v, contrast=c, noise_hz=n)
            for v in (30.0, 350.0) for c in (0.1, 0.8) for n in (1.0, 5.0)]  # fmt: skip
    kept = at_base(rows, ("speed_px_s", "contrast"))
    assert len(kept) == 4
    assert {r["noise_hz"] for r in kept} == {1.0}


def test_without_the_base_level_the_first_one_stands_in() -> None:
    rows = [row(noise_hz=n) for n in (7.0, 9.0)]
    assert [r["noise_hz"] for r in at_base(rows, ())] == [7.0]


def test_means_are_by_cell_and_a_cell_without_a_step_is_not_a_number() -> None:
    rows = [
        row(speed_px_s=30.0, noise_hz=0.0, right=0.5),
        row(speed_px_s=30.0, noise_hz=0.0, right=0.7, seed=1),
        row(speed_px_s=30.0, noise_hz=0.0, right=None, seed=2),
        row(speed_px_s=60.0, noise_hz=0.0, right=1.0),
        row(speed_px_s=60.0, noise_hz=5.0, right=None),
    ]
    found = means(rows, "speed_px_s", "noise_hz", RIGHT)
    np.testing.assert_allclose(found, [[0.6, 1.0], [np.nan, np.nan]])


def test_the_worst_level_counts() -> None:
    rows = [row(direction=d, right=r) for d, r in (("right", 0.9), ("up", 0.4))]
    np.testing.assert_allclose(worst(rows, "speed_px_s", "noise_hz", "direction", RIGHT), [[0.4]])


def test_a_method_holds_over_the_longest_run_of_speeds() -> None:
    shares = {30.0: 0.96, 60.0: 0.5, 120.0: 0.95, 240.0: 1.0}
    assert range_that_holds([row(speed_px_s=v, right=s) for v, s in shares.items()]) == (120, 240)
    assert range_that_holds([row(speed_px_s=v, right=0.9) for v in SPEEDS]) is None
    assert range_that_holds([row(speed_px_s=v, right=None) for v in SPEEDS]) is None


def test_a_speed_holds_by_the_mean_of_its_rows() -> None:
    rows = [row(speed_px_s=60.0, right=r, seed=k) for k, r in enumerate((0.9, 1.0))]
    assert range_that_holds(rows) == (60, 60)
