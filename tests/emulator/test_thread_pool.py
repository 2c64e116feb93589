import gc
import threading
from time import monotonic, sleep

import pytest

from emulator.thread_pool import ThreadPool


@pytest.mark.parametrize("size", [1, 2, 5])
def test_every_part_is_done_once_and_in_its_place(size: int) -> None:
    crew = ThreadPool(size)
    for _ in range(50):
        assert crew.share(lambda part: 10 * part) == [10 * part for part in range(size)]


def test_parts_run_at_the_same_time() -> None:
    meeting = threading.Barrier(3, timeout=10.0)
    ThreadPool(3).share(lambda _part: meeting.wait())


@pytest.mark.parametrize("bad", [0, 2])
def test_what_a_part_raises_is_raised_and_the_crew_goes_on(bad: int) -> None:
    crew = ThreadPool(3)

    def work(part: int) -> int:
        if part == bad:
            raise ValueError(f"part {part}")
        return part

    with pytest.raises(ValueError, match=f"part {bad}"):
        crew.share(work)
    assert crew.share(lambda part: part) == [0, 1, 2]


def test_threads_end_with_the_crew() -> None:
    before = set(threading.enumerate())  # of crews that end meanwhile, too
    crew = ThreadPool(4)
    crew.share(lambda part: part)
    own = set(threading.enumerate()) - before
    assert len(own) == 3
    del crew
    gc.collect()
    limit = monotonic() + 10.0
    while any(thread.is_alive() for thread in own) and monotonic() < limit:
        sleep(0.01)
    assert not any(thread.is_alive() for thread in own)
