"""Finished sequences of a study that was interrupted."""

from dataclasses import replace
from pathlib import Path

import pytest

from scenarios.study import runner
from scenarios.study.finished import FinishedSequences, finished_sequences, sequence_key
from scenarios.study.one_sequence import SequenceTask
from scenarios.study.results import SequenceResult
from scenarios.study.runner import run_sequences
from sim import CrossingConfig
from tests.scenarios.study.synthetic_results import make_sequence


def make_task(omega_rad_s: float) -> SequenceTask:
    return SequenceTask(CrossingConfig(omega_rad_s=omega_rad_s), ("fly",), (0, 1))


@pytest.fixture
def evaluated(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the tasks that were evaluated; that of 2 rad/s fails the first time."""
    names: list[str] = []

    def evaluate_crossing(task: SequenceTask, _: object) -> SequenceResult:
        names.append(task.name)
        if task.recording is not None:
            task.recording.write_text("recording")
        if names.count("day_2.00") == 1 and task.name == "day_2.00":
            raise KeyboardInterrupt
        return make_sequence("day", task.crossing.omega_rad_s)

    monkeypatch.setattr(runner, "evaluate_crossing", evaluate_crossing)
    return names


def test_a_study_goes_on_where_it_was_interrupted(tmp_path: Path, evaluated: list[str]) -> None:
    def run() -> list[SequenceResult]:
        with finished_sequences(tmp_path / "finished") as done:
            tasks = [done.recorded(make_task(omega)) for omega in (1.0, 2.0)]
            return run_sequences(tasks, jobs=1, finished=done)

    with pytest.raises(KeyboardInterrupt):
        run()
    assert len(list((tmp_path / "finished").iterdir())) == 2  # a result and its recording
    assert [result.name for result in run()] == ["day_1.00", "day_2.00"]
    assert evaluated == ["day_1.00", "day_2.00", "day_2.00"]


def test_nothing_is_left_if_nothing_was_finished(tmp_path: Path, evaluated: list[str]) -> None:
    def run() -> None:
        with finished_sequences(tmp_path / "finished") as done:
            run_sequences([done.recorded(make_task(2.0))], jobs=1, finished=done)

    with pytest.raises(KeyboardInterrupt):
        run()
    assert evaluated == ["day_2.00"]
    assert list(tmp_path.iterdir()) == []


def test_results_of_other_tasks_and_damaged_ones_are_not_used(tmp_path: Path) -> None:
    done, task = FinishedSequences(tmp_path), make_task(1.0)
    done.store(task, make_sequence("day", 1.0))
    assert done.load(task) is not None
    others = (
        make_task(1.5),
        replace(task, seeds=(0,)),
        replace(task, methods=("wide",)),
        replace(task, contrast_hop_us=10_000),
        replace(task, crossing=replace(task.crossing, step_px=4.0)),
        done.recorded(task),
    )
    assert [done.load(other) for other in others] == [None] * len(others)
    for damage in ("", "{}", "[1]", '{"lighting": 1}', "\0"):
        (tmp_path / f"{sequence_key(task)}.json").write_text(damage)
        assert done.load(task) is None
