"""Run a detector on a recording: equal estimates for any chunks, in constant memory."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyDetector
from detector.frame_fly.detector import FrameFly
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import EVENT_DTYPE, Events, empty_events
from formats import Chunk
from scenarios.detect.run_detector import RecordingSlice, run_detector
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.recording import FileRecorder, stream_recorder
from tests.detector.moving_dots import texture
from tests.scenarios.rrd_contents import RrdContents


def feed_of(detector: Any) -> DetectorFeed:
    return DetectorFeed("any", detector, width=346, height=260)


def slices(chunks: Sequence[Chunk] | Iterator[Chunk], detector: Any) -> list[RecordingSlice]:
    file: Any = chunks
    return list(run_detector(file, feed_of(detector)))


def estimates(found: list[RecordingSlice]) -> list[MotionEstimate]:
    return [estimate for part in found for estimate in part.estimates]


@pytest.fixture(scope="module")
def events() -> Events:
    return texture(400.0, Direction.UP, most=30_000)


@pytest.mark.parametrize("size", [30_000, 7_001, 64])
def test_the_size_of_chunks_does_not_matter(events: Events, size: int) -> None:
    chunks = [Chunk(events[n : n + size]) for n in range(0, events.size, size)]
    fly = FlyDetector()
    expected = fly.push(events) + fly.advance(int(events["t"][-1]) + 1)
    found = slices(chunks, FlyDetector())
    assert estimates(found) == expected
    assert np.array_equal(np.concatenate([part.events for part in found]), events)


def test_maps_belong_to_the_last_estimate(events: Events) -> None:
    fly = FlyDetector()
    for part in run_detector([Chunk(events)], feed_of(fly)):
        assert len(part.estimates) <= 1
        assert part.maps is fly.maps


@pytest.mark.parametrize("start_us", [20_000_000, 10**13])
def test_the_detectors_time_starts_with_the_recording(events: Events, start_us: int) -> None:
    late = events.copy()
    late["t"] += start_us
    early = estimates(slices([Chunk(events)], FlyDetector()))
    found = estimates(slices([Chunk(late)], FlyDetector()))
    assert [e.t_us - start_us for e in found] == [e.t_us for e in early]
    assert [e.vs for e in found] == [e.vs for e in early]


def frame(end_us: int) -> ApsFrame:
    return ApsFrame(end_us - 5000, end_us, np.full((260, 346), 100, np.uint16))


def test_frames_that_come_late_or_without_events_reach_the_detector() -> None:
    events = np.zeros(3, EVENT_DTYPE)
    events["t"] = 10_000, 50_000, 90_000
    chunks = [
        Chunk(events[:2]),
        Chunk(events[2:], (frame(20_000), frame(30_000), frame(80_000))),
        Chunk(empty_events(), (frame(200_000),)),
    ]
    found = slices(chunks, FrameFly())
    assert len(estimates(found)) == 3
    assert estimates(found)[-1].t_us == 200_000
    assert [f.end_us for part in found for f in part.frames] == [20_000, 30_000, 80_000, 200_000]


def test_an_empty_recording_gives_no_estimates() -> None:
    assert slices([], FlyDetector()) == []
    assert estimates(slices([Chunk(empty_events())], FlyDetector())) == []


class StatelessDetector:
    """Returns an estimate every 10 ms and stores nothing."""

    def __init__(self) -> None:
        self._hop = 0

    def push(self, _: Events) -> list[MotionEstimate]:
        return []

    def advance(self, t_us: int) -> list[MotionEstimate]:
        before, self._hop = self._hop, t_us // 10_000
        return [
            MotionEstimate(k * 10_000, 0.1, 0.0, Direction.RIGHT, 0.1, (1.0, 0.0), (5.0, 5.0), None)
            for k in range(before + 1, self._hop + 1)
        ]


def test_a_long_recording_is_written_in_constant_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """20 s: at most some thousand rows are in memory at a time, and all are in the file."""
    monkeypatch.setattr(stream_recorder, "MAX_ROWS", 1000)
    events = np.zeros(200, EVENT_DTYPE)
    most, rows = 0, 0

    def chunks() -> Iterator[Chunk]:
        for k in range(100):
            events["t"] = np.arange(200) * 1000 + k * 200_000
            yield Chunk(events.copy())

    options: Any = {"width": 346, "height": 260, "has_maps": False, "has_frames": False}
    path = tmp_path / "a.rrd"
    with FileRecorder(path, method="stateless", name="long", parameters={}, **options) as recorder:
        recorder._events._chunk_events = 500
        for part in run_detector(chunks(), feed_of(StatelessDetector())):
            recorder.log_events(part.events)
            for estimate in part.estimates:
                recorder.log_estimate("stateless", estimate)
                rows += 1
            most = max(most, recorder._columns.rows)
    assert rows == 1999
    assert most < 2500
    reading = RrdContents(path)
    assert len(reading.rows("/response/hs/stateless", "Scalars:scalars")) == rows
    assert len(reading.rows("/event_rate/on", "Scalars:scalars")) == 20_001
    assert len(reading.rows("/direction/1_stateless", "StateChange:state")) == 1


def test_a_pause_of_hours_needs_few_rows(tmp_path: Path) -> None:
    events = np.zeros(2, EVENT_DTYPE)
    events["t"] = 1_500, 3_600_000_000
    options: Any = {"width": 346, "height": 260, "has_maps": False, "has_frames": False}
    path = tmp_path / "a.rrd"
    with FileRecorder(path, method="stateless", name="pause", parameters={}, **options) as recorder:
        recorder.log_events(events)
    rows = RrdContents(path).rows("/event_rate/off", "Scalars:scalars")
    assert len(rows) < 20
    assert [t for t, (rate,) in rows if rate == 1.0] == pytest.approx([0.002, 3600.001])
