"""Sources of events that are placed where the geometry has moving objects."""

import functools

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from flybench.errors import EventError
from flybench.events import EVENT_DTYPE, Cause
from sim import Crossing, CrossingConfig, Distractors, RelativeDirection, SimError
from sim.event_truth import NOISE, event_truth
from sim.truth.dense_truth import BACKGROUND, DenseTruth


@pytest.fixture(scope="module")
def crossing() -> Crossing:
    return Crossing(CrossingConfig(distractors=Distractors(far_vehicle=RelativeDirection.OPPOSITE)))


def event_at_every_pixel(t_us: int) -> npt.NDArray[np.void]:
    """One event at each pixel."""
    rows, columns = np.indices((260, 346))
    events = np.zeros(rows.size, EVENT_DTYPE)
    events["t"], events["x"], events["y"] = t_us, columns.ravel(), rows.ravel()
    return events


@functools.cache
def geometry_of(crossing: Crossing) -> DenseTruth:
    return DenseTruth(crossing.scene, crossing.intrinsics)


def object_labels(crossing: Crossing, t_us: int) -> npt.NDArray[np.int8]:
    geometry = geometry_of(crossing)
    body = geometry.visible(crossing.seconds(t_us)).body
    return geometry.object_of_body[np.maximum(body, 0)]


def grown(mask: npt.NDArray[np.bool_], by_px: int) -> npt.NDArray[np.bool_]:
    square = np.ones((2 * by_px + 1, 2 * by_px + 1), np.uint8)
    return cv2.dilate(mask.astype(np.uint8), square).astype(np.bool_)


def test_events_on_and_next_to_an_object_belong_to_it(crossing: Crossing) -> None:
    t_us = int(0.4 * crossing.duration_us)
    found = event_truth(event_at_every_pixel(t_us), np.zeros(260 * 346), crossing, max_delay_us=0)
    source, there = found.source.reshape(260, 346), object_labels(crossing, t_us)
    assert set(np.unique(there)) == {-1, 0, 1}
    inside = [~grown(there != k, 2) for k in (0, 1)]
    for k in (0, 1):
        assert inside[k].sum() > 1_000
        assert (source[inside[k]] == k).all()
    rim = grown(there == 0, 1) & (there == -1) & ~grown(there == 1, 3)
    assert (source[rim] == 0).mean() > 0.9  # the position of a fast spoke may be half a pixel off
    assert (source[~grown(there >= 0, 3)] == BACKGROUND).all()


def test_the_flow_is_that_of_the_object_at_the_events_pixel(crossing: Crossing) -> None:
    t_us = int(0.4 * crossing.duration_us)
    events = event_at_every_pixel(t_us)
    found = event_truth(events, np.zeros(len(events)), crossing, tolerance_px=0.02)
    dense = geometry_of(crossing).flow_px_s(crossing.seconds(t_us))
    there = object_labels(crossing, t_us)
    inside = ~grown(there != 0, 3)
    difference = np.linalg.norm(found.flow_px_s.reshape(260, 346, 2) - dense, axis=-1)
    assert np.median(difference[inside]) < 0.5
    assert (difference[~grown(there >= 0, 3)] < 1e-3).all()


def test_noise_has_no_source_and_no_flow_at_any_pixel(crossing: Crossing) -> None:
    events = event_at_every_pixel(int(0.4 * crossing.duration_us))
    causes = np.where(np.arange(len(events)) % 2, Cause.SIGNAL, Cause.LEAK)
    found = event_truth(events, causes, crossing, signal={Cause.SIGNAL})
    assert np.array_equal(found.source == NOISE, causes == Cause.LEAK)
    assert np.array_equal(np.isnan(found.flow_px_s).all(axis=1), causes == Cause.LEAK)


def test_a_pixel_that_an_object_has_just_left_still_belongs_to_it(crossing: Crossing) -> None:
    """The target moves right; an event behind it is its own if the allowed delay is long enough."""
    t_us = int(0.5 * crossing.duration_us)
    row, labels = 150, object_labels(crossing, t_us)
    rear = int(np.flatnonzero(labels[row] == 0)[0])
    later_us = t_us + 30_000  # the target moves about 15 px in this time
    events = np.zeros(1, EVENT_DTYPE)
    events["t"], events["x"], events["y"] = later_us, rear + 4, row
    assert object_labels(crossing, later_us)[row, rear + 4] != 0
    short_delay = event_truth(events, [Cause.SIGNAL], crossing, max_delay_us=1_000)
    long_delay = event_truth(events, [Cause.SIGNAL], crossing, max_delay_us=40_000)
    assert short_delay.source[0] != 0
    assert long_delay.source[0] == 0
    assert long_delay.flow_px_s[0, 0] > 400


def test_the_source_is_that_at_the_time_of_each_event(crossing: Crossing) -> None:
    """Events of one pixel belong to the target exactly while the target covers the pixel."""
    times = np.arange(0, crossing.duration_us, 40_000)
    events = np.zeros(len(times), EVENT_DTYPE)
    events["t"], events["x"], events["y"] = times, 173, 150
    found = event_truth(events, np.zeros(len(times)), crossing, max_delay_us=0)
    expected = [object_labels(crossing, int(t))[150, 173] for t in times]
    assert set(expected) >= {-1, 0}
    assert np.mean(found.source == expected) > 0.95


def test_an_empty_stream_gives_empty_arrays(crossing: Crossing) -> None:
    found = event_truth(np.zeros(0, EVENT_DTYPE), [], crossing)
    assert found.source.shape == (0,)
    assert found.flow_px_s.shape == (0, 2)


def test_invalid_events_and_limits_are_refused(crossing: Crossing) -> None:
    events = np.zeros(2, EVENT_DTYPE)
    with pytest.raises(SimError, match=r"causes has shape \(1,\) for 2 events"):
        event_truth(events, [0], crossing)
    with pytest.raises(SimError, match="max_delay_us is -1"):
        event_truth(events, [0, 0], crossing, max_delay_us=-1)
    with pytest.raises(SimError, match=r"tolerance_px is 0\.0"):
        event_truth(events, [0, 0], crossing, tolerance_px=0.0)
    events["x"] = 346
    with pytest.raises(EventError, match="x = 346"):
        event_truth(events, [0, 0], crossing)
    events["x"], events["t"] = 0, [5, 4]
    with pytest.raises(EventError, match="t = 4 µs"):
        event_truth(events, [0, 0], crossing)
