"""All points of an envelope, measured side by side on every core."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from scenarios.envelope.measure import Row, measure
from scenarios.envelope.stimulus import Stimulus
from scenarios.pipeline.parallel import run_here


def measure_all(
    points: Sequence[Stimulus],
    methods: Sequence[str],
    *,
    jobs: int,
    progress: Callable[[int, int], None] = lambda _done, _all: None,
) -> list[Row]:
    """Measure every point with every method, in processes of one thread each.

    Args:
        points: the stimuli.
        methods: names that `find_method` knows.
        jobs: how many processes; −1: one a core.
        progress: told after every point how many are done, and of how many.

    Returns:
        Rows in the order of the points, and within one in that of the methods; the same however
        many processes there are.

    Raises:
        ScenarioError: that is no number of processes.
    """
    done: dict[int, list[Row]] = {}
    measured = run_here(partial(measure, methods=tuple(methods)), points, jobs=jobs)
    progress(0, len(points))
    for n, rows in measured:
        done[n] = rows
        progress(len(done), len(points))
    return [row for n in range(len(points)) for row in done[n]]
