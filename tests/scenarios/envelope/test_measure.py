import numpy as np
import pytest

from detector.fly.detector import FlyDetector
from flybench.direction import CARDINAL
from scenarios.envelope.drawing import draw
from scenarios.envelope.measure import measure
from scenarios.envelope.stimulus import Stimulus
from scenarios.errors import MethodError
from scenarios.pipeline.scoring import judge


def test_a_row_names_method_stimulus_and_result() -> None:
    stimulus = Stimulus(speed_px_s=600, noise_hz=2, seed=4)
    (row,) = measure(stimulus, ["fly"])
    drawn, fly = draw(stimulus), FlyDetector()
    estimates = fly.push(drawn.events) + fly.advance(drawn.duration_us + 1)
    expected = judge(estimates, "right", drawn.in_view_us, drawn)
    assert row["verdict"] == expected.pop("direction") == "right"
    assert {name: row[name] for name in expected} == expected
    assert (row["method"], row["speed_px_s"], row["seed"]) == ("fly", 600, 4)
    assert row["events"] == drawn.events.size
    assert row["detector_cpu_s"] > 0


@pytest.mark.parametrize(("speed_px_s", "known"), [(240, False), (250, True)])
def test_a_slow_target_is_there_from_the_start_and_has_no_latency(
    speed_px_s: float, known: bool
) -> None:
    (row,) = measure(Stimulus(speed_px_s=speed_px_s), ["fly"])
    assert row["accuracy"] > 0.5
    assert (row["latency_ms"] is not None) is known


@pytest.mark.parametrize("direction", CARDINAL)
def test_the_fly_is_right_in_its_range_in_every_direction(direction: str) -> None:
    stimulus = Stimulus(speed_px_s=600, noise_hz=5, direction=direction)  # type: ignore[arg-type]
    (row,) = measure(stimulus, ["fly"])
    assert row["accuracy_after_100ms"] >= 0.95
    assert row["verdict"] == direction
    assert 0 < row["roi_iou"] <= 1
    assert row["centroid_error_px"] < np.hypot(346, 260) / 2


def test_a_target_too_pale_to_be_seen_is_not_judged_right() -> None:
    (row,) = measure(Stimulus(contrast=0.0, speed_px_s=60, noise_hz=0), ["fly"])
    assert row["accuracy_after_100ms"] < 0.5
    shares = (row[f"{kind}_after_100ms"] for kind in ("accuracy", "opposite", "sideways", "none"))
    assert sum(shares) == pytest.approx(1.0)


def test_an_unknown_method_is_refused() -> None:
    with pytest.raises(MethodError, match="allowed is fly"):
        measure(Stimulus(speed_px_s=2000, noise_hz=0), ["bee"])
