"""The evaluation of a sequence of synthetic samples; `tests/scenarios/commands/test_study.py`
evaluates a rendered one."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from detector.estimate import MotionEstimate
from emulator import EventSensor, SensorConfig
from flybench.direction import Direction
from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY
from scenarios.study.conditions import HIGH_THRESHOLDS, high_thresholds
from scenarios.study.evaluation import SequenceEvaluation, velocity_errors
from scenarios.study.results import DEFAULT_SENSOR, SequenceResult
from scenarios.study.timed_detector import make_timed_detector
from sim import CrossingConfig
from tests.scenarios.pipeline.drawn_samples import CROSSING, bar_samples
from tests.scenarios.study.synthetic_results import make_sequence

SENSOR = SensorConfig()
SIZE: Any = {"width": SENSOR.width, "height": SENSOR.height}


@pytest.fixture(scope="module")
def result() -> SequenceResult:
    detectors = {
        (name, seed): [
            make_timed_detector(method, seed, sensor=name, **SIZE) for method in (FLY, FRAME_FLY)
        ]
        for name, seed in ((DEFAULT_SENSOR, 3), (DEFAULT_SENSOR, 8), (HIGH_THRESHOLDS, 3))
    }
    sensors = {DEFAULT_SENSOR: SENSOR, HIGH_THRESHOLDS: high_thresholds(SENSOR)}
    evaluation = SequenceEvaluation(CrossingConfig(), sensors, detectors)
    for sample in bar_samples():
        evaluation.add(sample)
    evaluation.finish()
    return evaluation.result(CROSSING)


def test_every_method_and_seed_has_a_run(result: SequenceResult) -> None:
    runs = [(run.sensor, run.seed, run.method) for run in result.runs]
    assert runs == [
        (name, seed, method)
        for name, seed in ((DEFAULT_SENSOR, 3), (DEFAULT_SENSOR, 8), (HIGH_THRESHOLDS, 3))
        for method in (FLY, FRAME_FLY)
    ]
    assert (result.name, result.direction) == ("day_1.61", "right")
    assert result.in_view_us == (0, 99 * 1_500)
    assert all(run.cpu_s > 0.0 for run in result.runs)
    assert result.runs[0].events == result.runs[1].events > 0
    assert result.runs[0].events != result.runs[2].events  # another sensor
    assert 0 < result.runs[4].events < 0.7 * result.runs[0].events  # fewer events an edge
    assert {shot.aps.shape for shot in result.snapshots} == {(260, 346)}


def test_estimates_do_not_depend_on_chunks(result: SequenceResult) -> None:
    sensor, detector = EventSensor(SENSOR, seed=8), make_timed_detector(FLY, 8, **SIZE)
    for sample in bar_samples():
        output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
        detector.process(output.events, output.aps_frames, until_us=sample.t_us + 1)
    (run,) = (run for run in result.runs if (run.seed, run.method) == (8, FLY))
    assert run.estimates == tuple(detector.estimates)
    assert len(run.estimates) == 14


def test_the_true_velocity_is_kept_every_10_ms(result: SequenceResult) -> None:
    steps = np.diff(result.velocity_t_us)
    assert steps.min() >= 10_000
    assert steps.max() <= 12_000
    assert result.velocity_px_s == pytest.approx(324 * 1.61, rel=0.01)


def test_velocity_errors_are_of_settled_steps_that_name_a_direction() -> None:
    sequence = replace(
        make_sequence(), velocity_t_us=np.array([0, 900_000]), velocity_px_s=np.array([0.0, 900.0])
    )

    def estimate(t_us: int, speed: float, direction: Direction = Direction.RIGHT) -> MotionEstimate:
        return MotionEstimate(t_us, 0.1, 0.0, direction, 0.1, (speed, 9.0), (0.0, 0.0), None)

    estimates = [
        estimate(250_000, 7.0),  # not settled yet
        estimate(400_000, 410.0),
        estimate(500_000, 480.0),
        estimate(600_000, 0.0, Direction.NONE),
        estimate(800_000, 7.0),  # out of view
    ]
    errors = velocity_errors(CONTRAST, estimates, sequence)
    assert errors is not None
    np.testing.assert_allclose(errors, [10.0, -20.0])
    assert velocity_errors(CONTRAST, estimates[3:4], sequence) is None
    assert velocity_errors(FLY, estimates, sequence) is None
