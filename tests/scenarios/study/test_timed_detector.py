from typing import Any

import numpy as np
import pytest

from detector.errors import DetectorConfigError
from emulator import ApsFrame, SensorOutput
from flybench.events import EVENT_DTYPE
from scenarios.errors import MethodError
from scenarios.pipeline.registry import (
    CONTRAST,
    FLY,
    FRAME_FLY,
    PLANE_FIT,
    SPACE_TIME,
    SPIKING,
    TIME_DIFFERENCE,
)
from scenarios.study.timed_detector import join_outputs, make_timed_detector, warm_up

SIZE: Any = {"width": 60, "height": 48}


def test_sensor_outputs_are_joined_in_order() -> None:
    events = np.zeros(3, EVENT_DTYPE)
    events["t"] = (5, 6, 9)
    frame = ApsFrame(0, 7, np.zeros((48, 60), np.uint16))
    none = np.empty(0, np.uint8)
    parts = ((events[:2], (frame,)), (events[:0], ()), (events[2:], ()))
    together, frames = join_outputs([SensorOutput(part, none, shots) for part, shots in parts])
    np.testing.assert_array_equal(together, events)
    assert frames == [frame]
    assert join_outputs([])[0].dtype == EVENT_DTYPE


@pytest.mark.parametrize(
    "method", [FLY, FRAME_FLY, CONTRAST, PLANE_FIT, SPACE_TIME, SPIKING, TIME_DIFFERENCE]
)
def test_a_warm_up_gives_estimates_and_counts_time_and_events(method: str) -> None:
    detector = make_timed_detector(method, 0, **SIZE)
    warm_up(detector, **SIZE)
    assert len(detector.estimates) >= 5
    assert detector.cpu_s > 0.0
    assert detector.events > 10_000
    assert (detector.maps is not None) == (method == FLY)


def test_a_warm_up_has_edges_to_which_planes_fit() -> None:
    """Otherwise the solver of their velocities is compiled in the first sequence."""
    size: Any = {"width": 346, "height": 260}
    detector = make_timed_detector(PLANE_FIT, 0, **size)
    warm_up(detector, **size)
    assert any(e.response != (0.0, 0.0) for e in detector.estimates)


def test_contrast_maximisation_has_the_hop_of_the_study() -> None:
    detector = make_timed_detector(CONTRAST, 0, contrast_hop_us=25_000, **SIZE)
    assert detector.config is not None
    assert detector.config.hop_us == 25_000
    with pytest.raises(DetectorConfigError, match="Allowed is a multiple of hop_us"):
        make_timed_detector(CONTRAST, 0, contrast_hop_us=30_000, **SIZE)


def test_an_unknown_method_is_refused() -> None:
    with pytest.raises(MethodError, match="'bee'"):
        make_timed_detector("bee", 0, **SIZE)
