"""The audience before drawn light; `test_command` has it before a rendered one."""

from dataclasses import replace

import numpy as np
import pytest

from detector.estimate import MotionEstimate
from emulator import EventSensor
from flybench.direction import Direction
from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY
from scenarios.study import one_sequence
from scenarios.study.one_sequence import Audience, SequenceTask, run_one, velocity_errors
from scenarios.study.results import Sequence
from scenarios.study.watcher import make_watcher
from sim import CrossingConfig
from tests.scenarios.pipeline.test_repeats import CROSSING, samples
from tests.scenarios.study.hand_made import a_sequence

TASK = SequenceTask(CrossingConfig(), methods=(FLY, FRAME_FLY), seeds=(3, 8))


@pytest.fixture(scope="module")
def seen() -> Sequence:
    audience = Audience(TASK)
    for sample in samples():
        audience.show(sample)
    audience.end()
    return audience.result(CROSSING)


def test_every_method_and_seed_has_a_run(seen: Sequence) -> None:
    runs = [(run.seed, run.method) for run in seen.runs]
    assert runs == [(3, FLY), (3, FRAME_FLY), (8, FLY), (8, FRAME_FLY)]
    assert (seen.name, seen.direction) == ("day_1.61", "right")
    assert seen.in_view_us == (0, 99 * 1_500)
    assert all(run.cpu_s > 0.0 for run in seen.runs)
    assert seen.runs[0].events == seen.runs[1].events > 0
    assert seen.runs[0].events != seen.runs[2].events  # another sensor
    assert {shot.aps.shape for shot in seen.snapshots} == {(260, 346)}


def test_chunks_change_nothing_of_what_is_said(seen: Sequence) -> None:
    sensor, watcher = EventSensor(TASK.sensor, seed=8), make_watcher(FLY, 8, width=346, height=260)
    for sample in samples():
        output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
        watcher.watch(output.events, output.aps_frames, until_us=sample.t_us + 1)
    (run,) = (run for run in seen.runs if (run.seed, run.method) == (8, FLY))
    assert run.estimates == tuple(watcher.estimates)
    assert len(run.estimates) == 14


def test_the_truth_of_velocity_is_kept_every_10_ms(seen: Sequence) -> None:
    steps = np.diff(seen.velocity_t_us)
    assert steps.min() >= 10_000
    assert steps.max() <= 12_000
    assert seen.velocity_px_s == pytest.approx(324 * 1.61, rel=0.01)


def test_velocity_is_judged_where_a_direction_is_named() -> None:
    sequence = replace(
        a_sequence(), velocity_t_us=np.array([0, 900_000]), velocity_px_s=np.array([0.0, 900.0])
    )

    def said(t_us: int, speed: float, direction: Direction = Direction.RIGHT) -> MotionEstimate:
        return MotionEstimate(t_us, 0.1, 0.0, direction, 0.1, (speed, 9.0), (0.0, 0.0), None)

    estimates = [
        said(250_000, 7.0),  # not settled yet
        said(400_000, 410.0),
        said(500_000, 480.0),
        said(600_000, 0.0, Direction.NONE),
        said(800_000, 7.0),  # gone
    ]
    errors = velocity_errors(CONTRAST, estimates, sequence)
    assert errors is not None
    np.testing.assert_allclose(errors, [10.0, -20.0])
    assert velocity_errors(CONTRAST, estimates[3:4], sequence) is None
    assert velocity_errors(FLY, estimates, sequence) is None


@pytest.mark.parametrize("ahead_us", [[], [0, 60_000, 148_500]])
def test_drawing_ahead_is_a_part_of_progress(
    monkeypatch: pytest.MonkeyPatch, ahead_us: list[int]
) -> None:
    monkeypatch.setattr(one_sequence, "make_crossing", lambda *_: CROSSING)
    monkeypatch.setattr(type(CROSSING), "draw_ahead", lambda _: iter(ahead_us))
    monkeypatch.setattr(type(CROSSING), "samples", lambda _: samples())
    told: list[float] = []
    run_one(replace(TASK, seeds=(3,)), lambda done, whole: told.append(done / whole))
    assert told == sorted(told)
    assert len(told) == len(ahead_us) + 100
    drawn_us = ahead_us[-1] if ahead_us else 0
    assert told[len(ahead_us)] == drawn_us / (drawn_us + CROSSING.duration_us)
