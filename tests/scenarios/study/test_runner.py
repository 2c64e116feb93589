"""What `run_all` does with results; `test_command` has it run real tasks."""

from pathlib import Path

import pytest

from scenarios.errors import ScenarioError
from scenarios.study import runner
from scenarios.study.one_sequence import SequenceTask
from scenarios.study.runner import run_all
from sim import CrossingConfig, Lighting


def tasks() -> list[SequenceTask]:
    return [
        SequenceTask(CrossingConfig(lighting=light, omega_rad_s=omega), ("fly",), (0,))
        for light, omega in ((Lighting.DAY, 1.0), (Lighting.NIGHT, 1.0), (Lighting.DAY, 2.0))
    ]


def test_nights_come_first_and_results_in_order(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    begun: list[str] = []

    def run_one(task: SequenceTask, progress: object) -> str:
        begun.append(task.name)
        return task.name

    monkeypatch.setattr(runner, "run_one", run_one)
    told: list[tuple[int, int]] = []
    found: list[object] = list(run_all(tasks(), jobs=1, progress=lambda *at: told.append(at)))
    assert begun == ["night_1.00", "day_1.00", "day_2.00"]
    assert found == ["day_1.00", "night_1.00", "day_2.00"]
    assert told[0] == (0, 3000)


def test_no_number_of_processes_is_refused() -> None:
    with pytest.raises(ScenarioError, match="jobs is 0"):
        run_all(tasks(), jobs=0)
