from typing import Any

import pytest

from scenarios.envelope.parallel import measure_all
from scenarios.envelope.stimulus import Stimulus
from scenarios.errors import ScenarioError

POINTS = [Stimulus(speed_px_s=v, noise_hz=0.5) for v in (2000.0, 1200.0, 1600.0)]


def without_times(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{k: v for k, v in row.items() if k != "detector_cpu_s"} for row in rows]


def test_processes_change_neither_results_nor_their_order() -> None:
    told: list[tuple[int, int]] = []
    alone = measure_all(POINTS, ["fly"], jobs=1)
    together = measure_all(POINTS, ["fly"], jobs=2, progress=lambda *done: told.append(done))
    assert without_times(together) == without_times(alone)
    assert [row["speed_px_s"] for row in together] == [2000, 1200, 1600]
    assert told == [(0, 3), (1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize("jobs", [0, -2])
def test_no_number_of_processes_is_refused(jobs: int) -> None:
    with pytest.raises(ScenarioError, match=f"jobs is {jobs}; allowed is 1 or more, or -1"):
        measure_all(POINTS, ["fly"], jobs=jobs)
