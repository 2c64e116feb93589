import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from emulator.readout.event_keys import MAX_STEP_US, make_key, unpack_keys
from flybench.events import check_events

WIDTH, HEIGHT = 1280, 720


@given(
    st.lists(
        st.tuples(
            st.floats(0.001, MAX_STEP_US), st.integers(0, WIDTH * HEIGHT - 1), st.integers(0, 6)
        )
    )
)
def test_keys_come_back_as_sorted_events(items: list[tuple[float, int, int]]) -> None:
    keys = np.array([make_key(t, MAX_STEP_US, pixel, mark) for t, pixel, mark in items], np.int64)
    start_us = 36_000_000_000
    events, causes = unpack_keys(np.sort(keys), start_us=start_us, width=WIDTH)
    check_events(events, width=WIDTH, height=HEIGHT)
    expected = sorted((int(np.ceil(t)), pixel, mark) for t, pixel, mark in items)
    found = [
        (int(e["t"]) - start_us, int(e["y"]) * WIDTH + int(e["x"]), 2 * int(c) + int(e["p"]))
        for e, c in zip(events, causes, strict=True)
    ]
    assert found == expected


def test_an_event_at_the_very_start_belongs_to_the_step() -> None:
    events, _ = unpack_keys(np.array([make_key(0.0, 1000, 5, 1)]), start_us=100, width=4)
    assert events["t"].tolist() == [101]


@given(st.integers(1, 1_000_000), st.integers(1, 100))
def test_an_event_at_the_end_of_the_last_piece_belongs_to_the_step(step_us: int, n: int) -> None:
    piece_us = step_us / n
    end_us = (n - 1) * piece_us + piece_us
    events, _ = unpack_keys(np.array([make_key(end_us, step_us, 5, 1)]), start_us=100, width=4)
    assert events["t"].tolist() == [100 + step_us]
