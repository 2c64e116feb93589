"""Synthetic stimuli shown to detectors, in one process and in several."""

from typing import Any

import numpy as np
import pytest

from detector.fly.detector import FlyDetector
from flybench.direction import CARDINAL
from scenarios.envelope.drawing import draw_stimulus
from scenarios.envelope.measure import measure, measure_all
from scenarios.envelope.stimulus import Stimulus
from scenarios.errors import MethodError, ScenarioError
from scenarios.pipeline.scoring import score_estimates


def test_a_row_holds_method_stimulus_and_scores() -> None:
    stimulus = Stimulus(speed_px_s=600, noise_hz=2, seed=4)
    (row,) = measure(stimulus, ["fly"])
    drawn, fly = draw_stimulus(stimulus), FlyDetector()
    estimates = fly.push(drawn.events) + fly.advance(drawn.duration_us + 1)
    expected = score_estimates(estimates, "right", drawn.in_view_us, drawn)
    assert row["verdict"] == expected.pop("direction") == "right"
    assert {name: row[name] for name in expected} == expected
    assert (row["method"], row["speed_px_s"], row["seed"]) == ("fly", 600, 4)
    assert row["events"] == drawn.events.size
    assert row["detector_cpu_s"] > 0


@pytest.mark.parametrize(("speed_px_s", "known"), [(240, False), (250, True)])
def test_a_slow_target_is_in_view_from_the_start_and_has_no_latency(
    speed_px_s: float, known: bool
) -> None:
    (row,) = measure(Stimulus(speed_px_s=speed_px_s), ["fly"])
    assert row["accuracy"] > 0.5
    assert (row["latency_ms"] is not None) is known


@pytest.mark.parametrize("direction", CARDINAL)
def test_the_fly_finds_every_direction_in_its_operating_range(direction: str) -> None:
    stimulus = Stimulus(speed_px_s=600, noise_hz=5, direction=direction)  # type: ignore[arg-type]
    (row,) = measure(stimulus, ["fly"])
    assert row["accuracy_after_100ms"] >= 0.95
    assert row["verdict"] == direction
    assert 0 < row["roi_iou"] <= 1
    assert row["centroid_error_px"] < np.hypot(346, 260) / 2


def test_a_target_without_contrast_is_not_found() -> None:
    (row,) = measure(Stimulus(contrast=0.0, speed_px_s=60, noise_hz=0), ["fly"])
    assert row["accuracy_after_100ms"] < 0.5
    shares = (row[f"{kind}_after_100ms"] for kind in ("accuracy", "opposite", "sideways", "none"))
    assert sum(shares) == pytest.approx(1.0)


def test_an_unknown_method_is_refused() -> None:
    with pytest.raises(MethodError, match="Allowed is fly"):
        measure(Stimulus(speed_px_s=2000, noise_hz=0), ["bee"])


POINTS = [Stimulus(speed_px_s=v, noise_hz=0.5) for v in (2000.0, 1200.0, 1600.0)]


def without_times(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{k: v for k, v in row.items() if k != "detector_cpu_s"} for row in rows]


def test_the_number_of_processes_changes_nothing() -> None:
    reported: list[tuple[int, int]] = []
    one = measure_all(POINTS, ["fly"], jobs=1)[0]
    two, _ = measure_all(POINTS, ["fly"], jobs=2, progress=lambda *done: reported.append(done))
    assert without_times(two) == without_times(one)
    assert [row["speed_px_s"] for row in two] == [2000, 1200, 1600]
    assert reported == [(0, 3), (1, 3), (2, 3), (3, 3)]


def test_an_invalid_number_of_processes_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"jobs is 0\. Allowed is 1 or more, or -1"):
        measure_all(POINTS, ["fly"], jobs=0)


def test_a_method_that_fails_is_left_out_with_its_reason() -> None:
    failing = "tests.scenarios.sweep.quick_sweep:FailingDetector"
    rows, failed = measure_all(POINTS[:1], ["fly", failing], jobs=1)
    assert [row["method"] for row in rows] == ["fly"]
    assert "RuntimeError: no nectar (quick_sweep.py, line" in failed[failing]
    with pytest.raises(MethodError, match="no nectar"):
        measure_all(POINTS[:1], [failing], jobs=1)
