"""Where events came from, for events put where geometry says that something moved."""

import functools

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from sim import Crossing, CrossingConfig, Distractors, RelativeDirection, SimError
from sim.event_truth import NOISE, event_truth
from sim.truth.dense_truth import BACKGROUND, DenseTruth

EVENT = np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "?")])
LIGHT, DARK_CURRENT = 0, 2


@pytest.fixture(scope="module")
def crossing() -> Crossing:
    return Crossing(CrossingConfig(distractors=Distractors(far_vehicle=RelativeDirection.OPPOSITE)))


def everywhere(t_us: int) -> npt.NDArray[np.void]:
    """An event at each pixel."""
    rows, columns = np.indices((260, 346))
    events = np.zeros(rows.size, EVENT)
    events["t"], events["x"], events["y"] = t_us, columns.ravel(), rows.ravel()
    return events


@functools.cache
def geometry_of(crossing: Crossing) -> DenseTruth:
    return DenseTruth(crossing.scene, crossing.intrinsics)


def labels(crossing: Crossing, t_us: int) -> npt.NDArray[np.int8]:
    geometry = geometry_of(crossing)
    body = geometry.visible(crossing.seconds(t_us)).body
    return geometry.object_of[np.maximum(body, 0)]


def grown(mask: npt.NDArray[np.bool_], by_px: int) -> npt.NDArray[np.bool_]:
    square = np.ones((2 * by_px + 1, 2 * by_px + 1), np.uint8)
    return cv2.dilate(mask.astype(np.uint8), square).astype(np.bool_)


def test_events_on_an_object_and_next_to_it_are_its_own(crossing: Crossing) -> None:
    t_us = int(0.4 * crossing.duration_us)
    found = event_truth(everywhere(t_us), np.zeros(260 * 346), crossing, light=LIGHT, memory_us=0)
    source, there = found.source.reshape(260, 346), labels(crossing, t_us)
    assert set(np.unique(there)) == {-1, 0, 1}
    inside = [~grown(there != k, 2) for k in (0, 1)]
    for k in (0, 1):
        assert inside[k].sum() > 1_000
        assert (source[inside[k]] == k).all()
    rim = grown(there == 0, 1) & (there == -1) & ~grown(there == 1, 3)
    assert (source[rim] == 0).mean() > 0.9  # half a pixel of the fastest spoke's way aside
    assert (source[~grown(there >= 0, 3)] == BACKGROUND).all()


def test_the_flow_is_that_of_the_object_at_the_place(crossing: Crossing) -> None:
    t_us = int(0.4 * crossing.duration_us)
    events = everywhere(t_us)
    found = event_truth(events, np.zeros(len(events)), crossing, light=LIGHT, within_px=0.02)
    dense = geometry_of(crossing).flow_px_s(crossing.seconds(t_us))
    there = labels(crossing, t_us)
    inside = ~grown(there != 0, 3)
    difference = np.linalg.norm(found.flow_px_s.reshape(260, 346, 2) - dense, axis=-1)
    assert np.median(difference[inside]) < 0.5
    assert (difference[~grown(there >= 0, 3)] < 1e-3).all()


def test_noise_is_noise_wherever_it_is(crossing: Crossing) -> None:
    events = everywhere(int(0.4 * crossing.duration_us))
    causes = np.where(np.arange(len(events)) % 2, LIGHT, DARK_CURRENT)
    found = event_truth(events, causes, crossing, light={LIGHT})
    assert np.array_equal(found.source == NOISE, causes == DARK_CURRENT)
    assert np.array_equal(np.isnan(found.flow_px_s).all(axis=1), causes == DARK_CURRENT)


def test_what_an_object_has_just_left_is_still_its_own(crossing: Crossing) -> None:
    """The target goes right: behind it, memory reaches as far as it goes in that time."""
    t_us = int(0.5 * crossing.duration_us)
    row, before = 150, labels(crossing, t_us)
    rear = int(np.flatnonzero(before[row] == 0)[0])
    later_us = t_us + 30_000  # some 15 px on
    events = np.zeros(1, EVENT)
    events["t"], events["x"], events["y"] = later_us, rear + 4, row
    assert labels(crossing, later_us)[row, rear + 4] != 0
    forgotten = event_truth(events, [LIGHT], crossing, light=LIGHT, memory_us=1_000)
    remembered = event_truth(events, [LIGHT], crossing, light=LIGHT, memory_us=40_000)
    assert forgotten.source[0] != 0
    assert remembered.source[0] == 0
    assert remembered.flow_px_s[0, 0] > 400


def test_times_are_the_events_own(crossing: Crossing) -> None:
    """One pixel over time: it is the target's exactly while the target is there."""
    times = np.arange(0, crossing.duration_us, 40_000)
    events = np.zeros(len(times), EVENT)
    events["t"], events["x"], events["y"] = times, 173, 150
    found = event_truth(events, np.zeros(len(times)), crossing, light=LIGHT, memory_us=0)
    expected = [labels(crossing, int(t))[150, 173] for t in times]
    assert set(expected) >= {-1, 0}
    assert np.mean(found.source == expected) > 0.95


def test_no_events_have_no_sources(crossing: Crossing) -> None:
    found = event_truth(np.zeros(0, EVENT), [], crossing, light=LIGHT)
    assert found.source.shape == (0,)
    assert found.flow_px_s.shape == (0, 2)


def test_bad_events_are_refused(crossing: Crossing) -> None:
    events = np.zeros(2, EVENT)
    with pytest.raises(SimError, match="2 events and causes of shape"):
        event_truth(events, [0], crossing, light=LIGHT)
    with pytest.raises(SimError, match="memory_us is -1"):
        event_truth(events, [0, 0], crossing, light=LIGHT, memory_us=-1)
    events["x"] = 346
    with pytest.raises(SimError, match="x = 346; allowed is 0 to 345"):
        event_truth(events, [0, 0], crossing, light=LIGHT)
    events["x"], events["t"] = 0, [5, 4]
    with pytest.raises(SimError, match="back in time"):
        event_truth(events, [0, 0], crossing, light=LIGHT)
