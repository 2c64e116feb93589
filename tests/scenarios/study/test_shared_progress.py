from pathlib import Path

from scenarios.study.shared_progress import SharedProgress


def test_the_sum_over_all_tasks_is_forwarded(tmp_path: Path) -> None:
    shared = SharedProgress.create(tmp_path / "progress", 2)
    sums: list[tuple[int, int]] = []
    with shared.forwarded_to(lambda done, total: sums.append((done, total))):
        shared.report(0, 5, 10)
        shared.report(1, 3, 3)
    assert sums[0] == (0, 2000)
    assert sums[-1] == (1500, 2000)
