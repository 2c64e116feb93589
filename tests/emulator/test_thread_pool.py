import gc
import threading
from time import monotonic, sleep

import pytest

from emulator.thread_pool import ThreadPool


@pytest.mark.parametrize("size", [1, 2, 5])
def test_every_part_runs_once_and_results_are_in_order(size: int) -> None:
    pool = ThreadPool(size)
    for _ in range(50):
        assert pool.run(lambda part: 10 * part) == [10 * part for part in range(size)]


def test_parts_run_at_the_same_time() -> None:
    meeting = threading.Barrier(3, timeout=10.0)
    ThreadPool(3).run(lambda _part: meeting.wait())


@pytest.mark.parametrize("bad", [0, 2])
def test_an_exception_of_a_part_is_raised_and_the_pool_stays_usable(bad: int) -> None:
    pool = ThreadPool(3)

    def work(part: int) -> int:
        if part == bad:
            raise ValueError(f"part {part}")
        return part

    with pytest.raises(ValueError, match=f"part {bad}"):
        pool.run(work)
    assert pool.run(lambda part: part) == [0, 1, 2]


def test_threads_end_with_the_pool() -> None:
    before = set(threading.enumerate())  # some may be of pools that are about to end
    pool = ThreadPool(4)
    pool.run(lambda part: part)
    own = set(threading.enumerate()) - before
    assert len(own) == 3
    del pool
    gc.collect()
    limit = monotonic() + 10.0
    while any(thread.is_alive() for thread in own) and monotonic() < limit:
        sleep(0.01)
    assert not any(thread.is_alive() for thread in own)
