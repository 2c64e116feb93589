"""The order of tasks and results; `test_study` runs real tasks."""

from dataclasses import replace
from pathlib import Path

import pytest

from scenarios.errors import ScenarioError
from scenarios.study import runner
from scenarios.study.one_sequence import SequenceTask
from scenarios.study.runner import run_sequences
from sim import CrossingConfig, Lighting


def tasks() -> list[SequenceTask]:
    still = [
        SequenceTask(CrossingConfig(lighting=lighting, omega_rad_s=omega), ("fly",), (0,))
        for lighting, omega in ((Lighting.DAY, 1.0), (Lighting.NIGHT, 1.0), (Lighting.DAY, 2.0))
    ]
    moving = [
        replace(still[night], background=background)
        for night, background in ((0, "wind"), (0, "all"), (1, "all"))
    ]
    return still + moving


def test_the_longest_run_first_and_results_keep_the_order(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    begun: list[str] = []

    def evaluate_crossing(task: SequenceTask, progress: object) -> str:
        begun.append(task.name)
        return task.name

    monkeypatch.setattr(runner, "evaluate_crossing", evaluate_crossing)
    progress: list[tuple[int, int]] = []
    found: list[object] = list(
        run_sequences(tasks(), jobs=1, progress=lambda *at: progress.append(at))
    )
    moving = ["day_1.00_wind", "day_1.00_all", "night_1.00_all"]
    assert begun == ["night_1.00", moving[2], "day_1.00", "day_2.00", moving[1], moving[0]]
    assert found == ["day_1.00", "night_1.00", "day_2.00", *moving]
    assert progress[0] == (0, 6000)


def test_zero_processes_are_refused() -> None:
    with pytest.raises(ScenarioError, match="jobs is 0"):
        run_sequences(tasks(), jobs=0)
