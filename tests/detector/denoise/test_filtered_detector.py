"""Detectors behind a filter."""

import numpy as np
import pytest

from detector import Detector, EventOrderError, FlyDetector, FrameDetector, MotionEstimate, PlaneFit
from detector.denoise import FILTERS, filtered
from flybench.errors import EventError
from flybench.events import EVENT_DTYPE
from scenarios.errors import MethodError
from scenarios.pipeline.user_detectors import find_method
from tests.detector.denoise.test_filters import edge_and_noise

SIZE = {"width": 346, "height": 260}


def estimates_of(detector: Detector, cuts: list[int]) -> list[MotionEstimate]:
    found = []
    for part in np.split(edge_and_noise()[0], cuts):
        found += detector.push(part)
    return found + detector.advance(350_000)


def test_the_detector_sees_what_the_filter_keeps_however_the_stream_is_cut() -> None:
    events, _ = edge_and_noise()
    plane_fit = PlaneFit()
    kept = FILTERS["stcf"](**SIZE).keep(events)
    expected = plane_fit.push(kept) + plane_fit.advance(350_000)
    for cuts in ([], [1, 2, 5000, 5001, 30_000]):
        got = estimates_of(find_method("stcf+plane-fit").make(**SIZE), cuts)
        assert [e.t_us for e in got] == [e.t_us for e in expected]
        assert [e.response for e in got] == [e.response for e in expected]
    plain = estimates_of(PlaneFit(), [])
    assert [e.response for e in plain] != [e.response for e in expected]


def test_a_frame_detector_still_takes_frames_and_others_do_not() -> None:
    framed = find_method("baf+frame-fly").make(**SIZE)
    assert isinstance(framed, FrameDetector)
    assert not isinstance(find_method("baf+fly").make(**SIZE), FrameDetector)
    assert framed.push_frame(1000, np.zeros((260, 346), np.uint16)) == []


def test_maps_and_memory_are_those_of_the_detector() -> None:
    fly = FlyDetector()
    made = filtered(FILTERS["baf"](**SIZE), fly)
    assert made.maps is fly.maps
    assert made.memory_us == fly.memory_us


def test_bad_events_are_refused_before_the_filter_sees_them() -> None:
    made = filtered(FILTERS["stcf"](**SIZE), FlyDetector())
    events = np.zeros(2, EVENT_DTYPE)
    events["x"] = 346
    with pytest.raises(EventError, match="x = 346"):
        made.push(events)
    events["x"], events["t"] = 0, 500
    made.push(events)
    with pytest.raises(EventOrderError):
        made.push(np.zeros(1, EVENT_DTYPE))


def test_an_unknown_filter_is_named() -> None:
    with pytest.raises(MethodError, match=r"no filter 'median'\. Allowed before the \+"):
        find_method("median+fly")
    with pytest.raises(MethodError, match=r"The method is 'flea'"):
        find_method("stcf+flea")
