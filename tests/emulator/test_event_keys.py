import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from emulator import check_events
from emulator.event_keys import MAX_STEP_US, make_key, unpack_keys

WIDTH, HEIGHT = 1280, 720


@given(
    st.lists(
        st.tuples(
            st.floats(0.001, MAX_STEP_US), st.integers(0, WIDTH * HEIGHT - 1), st.integers(0, 6)
        )
    )
)
def test_keys_come_back_as_sorted_events(items: list[tuple[float, int, int]]) -> None:
    keys = np.array([make_key(*item) for item in items], np.int64)
    start_us = 36_000_000_000
    events, causes = unpack_keys(keys, start_us=start_us, width=WIDTH)
    check_events(events, width=WIDTH, height=HEIGHT)
    expected = sorted((int(np.ceil(t)), pixel, mark) for t, pixel, mark in items)
    found = [
        (int(e["t"]) - start_us, int(e["y"]) * WIDTH + int(e["x"]), 2 * int(c) + int(e["p"]))
        for e, c in zip(events, causes, strict=True)
    ]
    assert found == expected


def test_an_event_at_the_very_start_belongs_to_the_step() -> None:
    events, _ = unpack_keys(np.array([make_key(0.0, 5, 1)]), start_us=100, width=4)
    assert events["t"].tolist() == [101]
