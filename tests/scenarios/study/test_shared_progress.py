from pathlib import Path

from scenarios.study.shared_progress import SharedProgress


def test_the_sum_of_all_tasks_is_told(tmp_path: Path) -> None:
    shared = SharedProgress.begin(tmp_path / "progress", 2)
    told: list[tuple[int, int]] = []
    with shared.watched(lambda done, total: told.append((done, total))):
        shared.tell(0, 5, 10)
        shared.tell(1, 3, 3)
    assert told[0] == (0, 2000)
    assert told[-1] == (1500, 2000)
