"""Recordings from which nothing can be calibrated are refused with one sentence."""

from dataclasses import replace

import numpy as np
import pytest

from emulator import ApsConfig, ApsFrame
from flybench.events import Events, empty_events
from formats import Chunk
from scenarios.calibrate.recording import (
    CalibrationRecording,
    events_by_pixel,
    from_aps,
    read_recording,
)
from scenarios.errors import ScenarioError
from tests.scenarios.event_statistics.made_events import events_of

EVENTS = events_of(*[(1000, 1, 0, True), (50_000, 0, 1, False), (90_000, 1, 0, False)])


def frame(start_us: int, level: int = 100, shape: tuple[int, int] = (2, 3)) -> ApsFrame:
    return ApsFrame(start_us, start_us + 10_000, np.full(shape, level, np.uint16))


TWO = (frame(5_000), frame(45_000, 200))


@pytest.mark.parametrize(
    ("events", "frames", "words"),
    [
        (EVENTS, (), "has no frames. Allowed are recordings with 2 frames or more"),
        (EVENTS, TWO[:1], "has one frame"),
        (EVENTS, (frame(5_000), frame(45_000)), "All 2 frames of it are equal"),
        (empty_events(), TWO, "contains 0 events in 0 s"),
        (EVENTS[:1], TWO, "contains 1 events in 0 s"),
        (EVENTS, (frame(500_000), frame(540_000, 9)), "frames from 0.500 to 0.550 s; 0 frames"),
    ],
)
def test_a_recording_without_what_is_needed_is_refused(
    events: Events, frames: tuple[ApsFrame, ...], words: str
) -> None:
    with pytest.raises(ScenarioError, match=words):
        from_aps(events, frames, ApsConfig(), name="it")


def test_frames_of_another_size_are_refused() -> None:
    chunks = [Chunk(EVENTS, (frame(5_000, shape=(4, 4)),))]
    with pytest.raises(ScenarioError, match="a frame of 4×4 px, but events of a sensor of 3×2 px"):
        read_recording(chunks, width=3, height=2, name="it")


def test_events_are_sorted_by_pixel_and_time() -> None:
    found = events_by_pixel(EVENTS, (2, 3))
    np.testing.assert_array_equal(found.pixel, [1, 1, 3])
    np.testing.assert_array_equal(found.t, [1000, 90_000, 50_000])
    np.testing.assert_array_equal(found.offsets, [0, 0, 2, 2, 3, 3, 3])


def test_levels_give_the_illuminance_that_the_frames_collected() -> None:
    aps = ApsConfig()
    recording = from_aps(EVENTS, TWO, aps, name="it")
    expected = 100 * aps.electrons_per_dn / (aps.electrons_per_lux_s * 0.01)
    assert recording.lux_per_level[0] * 100 == pytest.approx(expected)


def test_a_part_has_its_own_events_and_frames() -> None:
    recording = from_aps(EVENTS, (*TWO, frame(70_000, 300)), ApsConfig(), name="it")
    part = recording.between(40_000, 95_000)
    assert (part.events.size, len(part.frames)) == (2, 2)
    with pytest.raises(ScenarioError, match="This part of the recording has one frame"):
        recording.between(0, 40_000)


def test_a_recording_that_is_too_long_is_used_up_to_a_limit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("scenarios.calibrate.recording.MAX_FRAMES", 3)
    chunks = (Chunk(EVENTS[:1], TWO) for _ in range(9))
    events, frames, whole = read_recording(chunks, width=3, height=2, name="it")
    assert (events.size, len(frames), whole) == (2, 3, False)
    assert not replace(CalibrationRecording(events, TWO, np.ones(2)), whole=whole).whole
