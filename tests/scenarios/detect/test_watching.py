"""A file before a detector: the same as all at once, and no more memory however long it is."""

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
from scenarios.detect.watching import Look, watch
from scenarios.recording import FileRecorder, stream_recorder
from tests.detector.moving_dots import texture
from tests.scenarios.rrd_contents import RrdContents


def looks(chunks: Sequence[Chunk] | Iterator[Chunk], detector: Any) -> list[Look]:
    file: Any = chunks
    return list(watch(file, detector))


def told(found: list[Look]) -> list[MotionEstimate]:
    return [estimate for look in found for estimate in look.estimates]


@pytest.fixture(scope="module")
def events() -> Events:
    return texture(400.0, Direction.UP, most=30_000)


@pytest.mark.parametrize("size", [30_000, 7_001, 64])
def test_cuts_change_nothing(events: Events, size: int) -> None:
    chunks = [Chunk(events[n : n + size]) for n in range(0, events.size, size)]
    whole = FlyDetector()
    expected = whole.push(events) + whole.advance(int(events["t"][-1]) + 1)
    found = looks(chunks, FlyDetector())
    assert told(found) == expected
    assert np.array_equal(np.concatenate([look.events for look in found]), events)


def test_maps_are_those_of_the_estimate(events: Events) -> None:
    fly = FlyDetector()
    for look in watch([Chunk(events)], fly):  # type: ignore[arg-type]
        assert len(look.estimates) <= 1
        assert look.maps is fly.maps


@pytest.mark.parametrize("start_us", [20_000_000, 10**13])
def test_the_detectors_time_starts_with_the_recording(events: Events, start_us: int) -> None:
    late = events.copy()
    late["t"] += start_us
    at_once = told(looks([Chunk(events)], FlyDetector()))
    found = told(looks([Chunk(late)], FlyDetector()))
    assert [e.t_us - start_us for e in found] == [e.t_us for e in at_once]
    assert [e.vs for e in found] == [e.vs for e in at_once]


def frame(end_us: int) -> ApsFrame:
    return ApsFrame(end_us - 5000, end_us, np.full((260, 346), 100, np.uint16))


def test_frames_that_come_late_or_alone_are_shown_all_the_same() -> None:
    events = np.zeros(3, EVENT_DTYPE)
    events["t"] = 10_000, 50_000, 90_000
    chunks = [
        Chunk(events[:2]),
        Chunk(events[2:], (frame(20_000), frame(30_000), frame(80_000))),
        Chunk(empty_events(), (frame(200_000),)),
    ]
    found = looks(chunks, FrameFly())
    assert len(told(found)) == 3
    assert told(found)[-1].t_us == 200_000
    assert [f.end_us for look in found for f in look.frames] == [20_000, 30_000, 80_000, 200_000]


def test_nothing_gives_nothing() -> None:
    assert looks([], FlyDetector()) == []
    assert told(looks([Chunk(empty_events())], FlyDetector())) == []


class Waver:
    """Says something every 10 ms, and keeps nothing."""

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


def test_a_long_recording_is_written_as_it_comes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """20 s, of which never more than a thousand rows are in memory; all of them in the file."""
    monkeypatch.setattr(stream_recorder, "MAX_ROWS", 1000)
    events = np.zeros(200, EVENT_DTYPE)
    most, rows = 0, 0

    def chunks() -> Iterator[Chunk]:
        for k in range(100):
            events["t"] = np.arange(200) * 1000 + k * 200_000
            yield Chunk(events.copy())

    options: Any = {"width": 346, "height": 260, "has_maps": False, "has_frames": False}
    path = tmp_path / "a.rrd"
    with FileRecorder(path, method="waver", name="long", parameters={}, **options) as recorder:
        recorder._events._chunk_events = 500
        for look in watch(chunks(), Waver()):  # type: ignore[arg-type]
            recorder.log_events(look.events)
            for estimate in look.estimates:
                recorder.log_estimate("waver", estimate)
                rows += 1
            most = max(most, recorder._columns.rows)
    assert rows == 1999
    assert most < 2500
    reading = RrdContents(path)
    assert len(reading.rows("/response/hs/waver", "Scalars:scalars")) == rows
    assert len(reading.rows("/event_rate/on", "Scalars:scalars")) == 20_001
    assert len(reading.rows("/direction/1_waver", "StateChange:state")) == 1


def test_a_quiet_of_hours_costs_no_row_a_millisecond(tmp_path: Path) -> None:
    events = np.zeros(2, EVENT_DTYPE)
    events["t"] = 1_500, 3_600_000_000
    options: Any = {"width": 346, "height": 260, "has_maps": False, "has_frames": False}
    path = tmp_path / "a.rrd"
    with FileRecorder(path, method="waver", name="quiet", parameters={}, **options) as recorder:
        recorder.log_events(events)
    rows = RrdContents(path).rows("/event_rate/off", "Scalars:scalars")
    assert len(rows) < 20
    assert [t for t, (rate,) in rows if rate == 1.0] == pytest.approx([0.002, 3600.001])
