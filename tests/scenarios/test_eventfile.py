from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emulator import EVENT_DTYPE
from scenarios.eventfile import DsecWriter, read_events


@settings(max_examples=20, deadline=None)
@given(
    times=st.lists(st.integers(0, 20_000), max_size=200).map(sorted),
    cuts=st.lists(st.integers(0, 200), max_size=5).map(sorted),
)
def test_events_come_back_with_their_index(
    tmp_path_factory: pytest.TempPathFactory, times: list[int], cuts: list[int]
) -> None:
    path: Path = tmp_path_factory.mktemp("h5") / "events.h5"
    events = np.zeros(len(times), EVENT_DTYPE)
    events["t"] = times
    events["x"] = np.arange(len(times)) % 346
    events["y"] = np.arange(len(times)) % 260
    events["p"] = np.arange(len(times)) % 3 == 0
    with DsecWriter(path, width=346, height=260) as writer:
        for part in np.split(events, cuts):
            writer.write(part)
    assert np.array_equal(read_events(path), events)
    with h5py.File(path) as file:
        for name in ("t", "x", "y", "p"):
            assert np.array_equal(file["events"][name][:], events[name])
        index = file["ms_to_idx"][:]
        assert np.array_equal(index, np.searchsorted(events["t"], np.arange(index.size) * 1000))
        assert index[-1] == events.size
        assert file.attrs["width"] == 346
