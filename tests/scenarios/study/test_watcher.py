import numpy as np
import pytest

from detector.errors import DetectorConfigError
from emulator import ApsFrame, SensorOutput
from flybench.events import EVENT_DTYPE
from scenarios.errors import MethodError
from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY, PLANE_FIT
from scenarios.study.watcher import gathered, make_watcher, warm_up

SIZE = {"width": 60, "height": 48}


def test_steps_are_joined_in_their_order() -> None:
    events = np.zeros(3, EVENT_DTYPE)
    events["t"] = (5, 6, 9)
    frame = ApsFrame(0, 7, np.zeros((48, 60), np.uint16))
    none = np.empty(0, np.uint8)
    parts = ((events[:2], (frame,)), (events[:0], ()), (events[2:], ()))
    together, frames = gathered([SensorOutput(part, none, shots) for part, shots in parts])
    np.testing.assert_array_equal(together, events)
    assert frames == [frame]
    assert gathered([])[0].dtype == EVENT_DTYPE


@pytest.mark.parametrize("method", [FLY, FRAME_FLY, CONTRAST, PLANE_FIT])
def test_a_warm_up_calls_all_and_counts_time_and_events(method: str) -> None:
    watcher = make_watcher(method, 0, **SIZE)
    warm_up(watcher, **SIZE)
    assert len(watcher.estimates) >= 5
    assert watcher.cpu_s > 0.0
    assert watcher.events > 10_000
    assert (watcher.maps is not None) == (method == FLY)


def test_contrast_maximisation_has_the_hop_of_the_study() -> None:
    watcher = make_watcher(CONTRAST, 0, contrast_hop_us=25_000, **SIZE)
    assert watcher.config is not None
    assert watcher.config.hop_us == 25_000
    with pytest.raises(DetectorConfigError, match="Allowed is a multiple of hop_us"):
        make_watcher(CONTRAST, 0, contrast_hop_us=30_000, **SIZE)


def test_an_unknown_method_is_refused() -> None:
    with pytest.raises(MethodError, match="'bee'"):
        make_watcher("bee", 0, **SIZE)
