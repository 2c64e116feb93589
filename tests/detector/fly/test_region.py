import numpy as np

from detector.fly.region import region_of_interest


def test_contains_only_connected_cells() -> None:
    activity = np.zeros((30, 30), np.float32)
    activity[10:14, 10:14] = 1.0
    activity[14, 14] = 1.0
    activity[10:14, 17:20] = 1.0
    region = region_of_interest(activity, (12.0, 12.0), reach=10.0, share=0.1)
    expected = np.zeros((30, 30), np.bool_)
    expected[10:14, 10:14] = expected[14, 14] = True
    np.testing.assert_array_equal(region, expected)


def test_stays_within_reach_of_the_view_centre() -> None:
    region = region_of_interest(np.ones((40, 40), np.float32), (20.0, 3.0), reach=5.0, share=0.1)
    rows, columns = np.nonzero(region)
    assert (columns.min(), columns.max(), rows.min(), rows.max()) == (15, 25, 0, 8)


def test_grows_from_the_nearest_active_cell_if_the_centre_is_inactive() -> None:
    activity = np.zeros((30, 30), np.float32)
    activity[5, 5] = activity[5, 16] = 1.0
    region = region_of_interest(activity, (13.0, 5.0), reach=12.0, share=0.1)
    assert np.argwhere(region).tolist() == [[5, 16]]


def test_excludes_weak_activity() -> None:
    activity = np.full((20, 20), 0.05, np.float32)
    activity[9:12, 9:12] = 1.0
    assert region_of_interest(activity, (10.0, 10.0), reach=8.0, share=0.1).sum() == 9


def test_is_empty_if_the_square_contains_no_cell() -> None:
    activity = np.ones((30, 30), np.float32)
    assert not region_of_interest(activity, (12.5, 12.5), reach=1 / 3, share=0.1).any()


def test_is_empty_if_no_cell_within_reach_is_active() -> None:
    activity = np.zeros((30, 30), np.float32)
    activity[25, 25] = 1.0
    assert not region_of_interest(activity, (5.0, 5.0), reach=6.0, share=0.1).any()
