"""Time to record a million events as a Rerun file, and the size of the file."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flybench.events import EVENT_DTYPE
from scenarios.recording import Recorder
from sim import Crossing, CrossingConfig

EVENTS = 1_000_000


@pytest.mark.benchmark(group="recording")
def test_record_a_million_events(benchmark: Any, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    crossing = Crossing(CrossingConfig())
    events = np.zeros(EVENTS, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, crossing.duration_us, EVENTS))
    events["x"], events["y"] = rng.integers(0, 346, EVENTS), rng.integers(0, 260, EVENTS)
    events["p"] = rng.random(EVENTS) < 0.5
    chunks = np.array_split(events, 1000)
    file = tmp_path / "recording.rrd"

    def record() -> None:
        with Recorder(file, crossing=crossing, parameters={}) as recorder:
            for chunk in chunks:
                recorder.log_events(chunk)

    benchmark.pedantic(record, rounds=3, warmup_rounds=1)
    benchmark.extra_info["file_mb"] = file.stat().st_size / 1e6
