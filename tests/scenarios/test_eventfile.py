from pathlib import Path

import numpy as np

from emulator import EVENT_DTYPE
from scenarios.eventfile import DsecWriter, read_events


def test_a_runs_events_come_back(tmp_path: Path) -> None:
    events = np.zeros(3, EVENT_DTYPE)
    events["t"] = 0, 5, 1_000_000
    with DsecWriter(tmp_path / "events.h5", width=346, height=260) as writer:
        writer.write(events[:1])
        writer.write(events[1:])
    assert np.array_equal(read_events(tmp_path / "events.h5"), events)
