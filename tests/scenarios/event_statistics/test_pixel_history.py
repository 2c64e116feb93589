import numpy as np

from flybench.events import Events
from scenarios.event_statistics.pixel_history import MAX_RUN, PixelHistory
from tests.scenarios.event_statistics.made_events import SIZE, edge_events, events_of, noise_events


def history_of(*blocks: Events) -> PixelHistory:
    history = PixelHistory(**SIZE)
    for block in blocks:
        history.add(block)
    return history


def runs_of(history: PixelHistory) -> tuple[dict[int, int], dict[int, int]]:
    """Number of runs by length: those that are no edges, and edges."""
    others, edges = ({int(k): int(row[k]) for k in np.flatnonzero(row)} for row in history.runs)
    return others, edges


def test_intervals_are_split_by_whether_the_polarity_changes() -> None:
    history = history_of(events_of((0, 5, 5, 1), (40, 5, 5, 1), (100, 5, 5, 0), (103, 6, 5, 0)))
    same, other = history.intervals
    assert np.flatnonzero(same).tolist() == [40]
    assert np.flatnonzero(other).tolist() == [60]
    assert history.changes.sum() == history.changes[5, 5] == 1
    assert history.counts[:, 5, 5].tolist() == [1, 2]


def test_a_predecessor_may_be_behind_an_event_of_the_other_polarity() -> None:
    stream = events_of((0, 5, 5, 1), (10_000, 5, 5, 0), (30_000, 5, 5, 1), (60_001, 5, 5, 1))
    assert history_of(stream).with_predecessor == 1


def test_a_run_ends_with_a_change_of_polarity_and_after_30_ms() -> None:
    times = (0, 30_000, 60_000), (60_001, 60_002), (90_003,)
    rows = [(t, 5, 5, p) for p, group in zip((1, 0, 0), times, strict=True) for t in group]
    assert runs_of(history_of(events_of(*rows))) == ({3: 1, 2: 1, 1: 1}, {})


def test_a_run_is_an_edge_if_a_neighbour_fires_the_same_polarity_within_5_ms() -> None:
    late, other, far = (5000, 6, 6, 1), (1, 6, 6, 0), (1, 7, 5, 1)
    for event in (late, other, far):
        stream = np.sort(events_of((0, 5, 5, 1), event), order="t")
        assert runs_of(history_of(stream)) == ({1: 2}, {})
    assert runs_of(history_of(events_of((0, 5, 5, 1), (4999, 6, 6, 1)))) == ({}, {1: 2})


def test_a_pixel_at_the_border_has_no_neighbours_on_the_other_side() -> None:
    stream = events_of((0, 0, 0, 1), (1, 31, 0, 1), (2, 0, 23, 1), (3, 31, 23, 1))
    assert runs_of(history_of(stream)) == ({1: 4}, {})


def test_a_moving_edge_gives_every_pixel_its_number_of_events() -> None:
    history = history_of(edge_events(px_s=500.0, events_each=4))
    assert runs_of(history) == ({}, {4: 32 * 24})
    assert history.with_predecessor == 3 * 32 * 24


def test_longer_runs_than_the_histogram_are_counted_at_its_end() -> None:
    rows = [(k, 5, 5, 1) for k in range(MAX_RUN + 50)]
    assert runs_of(history_of(events_of(*rows))) == ({MAX_RUN: 1}, {})


def test_blocks_change_nothing() -> None:
    stream = noise_events(20.0, 400_000)
    whole, parts = history_of(stream), history_of(*np.array_split(stream, 17))
    for name in ("counts", "changes", "intervals", "runs"):
        assert np.array_equal(getattr(whole, name), getattr(parts, name)), name
    assert whole.with_predecessor == parts.with_predecessor > 0
