"""All points of an envelope, measured side by side on every core."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from joblib import Parallel, delayed, parallel_config

from scenarios.envelope.measure import Row, measure
from scenarios.envelope.stimulus import Stimulus
from scenarios.errors import ScenarioError

ONE_A_CORE = -1


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
    if jobs != ONE_A_CORE and jobs < 1:
        raise ScenarioError(
            f"jobs is {jobs}; allowed is 1 or more, or -1 for one a core; leave it out for that"
        )
    done: dict[int, list[Row]] = {}
    progress(0, len(points))
    with parallel_config(backend="loky", n_jobs=jobs, inner_max_num_threads=1):
        for n, rows in _as_they_come(points, methods):
            done[n] = rows
            progress(len(done), len(points))
    return [row for n in range(len(points)) for row in done[n]]


def _as_they_come(
    points: Sequence[Stimulus], methods: Sequence[str]
) -> Iterator[tuple[int, list[Row]]]:
    tasks = (delayed(_numbered)(n, point, tuple(methods)) for n, point in enumerate(points))
    results: Iterator[tuple[int, list[Row]]] = Parallel(return_as="generator_unordered")(tasks)
    return results


def _numbered(n: int, point: Stimulus, methods: Sequence[str]) -> tuple[int, list[Row]]:
    return n, measure(point, methods)
