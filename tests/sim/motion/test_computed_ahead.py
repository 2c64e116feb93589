"""Values computed ahead are those of their times, whatever times are asked for."""

from sim.motion.computed_ahead import BLOCK, ComputedAhead


class Doubles:
    """Doubles times, and remembers which."""

    def __init__(self) -> None:
        """Remember nothing yet."""
        self.asked: list[int] = []

    def __call__(self, time: int) -> int:
        """Return twice the time."""
        self.asked.append(time)
        return 2 * time


def test_every_announced_time_is_computed_once() -> None:
    doubles, times = Doubles(), list(range(0, 30 * BLOCK, 10))
    ahead = ComputedAhead(doubles, times)
    for k, time in enumerate(times):
        assert ahead.at(time) == 2 * time
        assert len(doubles.asked) <= k + BLOCK
    assert doubles.asked == times


def test_a_start_in_the_middle_computes_nothing_before_it() -> None:
    doubles, times = Doubles(), list(range(10 * BLOCK))
    first = 5 * BLOCK + 3
    assert ComputedAhead(doubles, times).at(first) == 2 * first
    assert doubles.asked == times[first : first + BLOCK]


def test_times_in_between_are_computed_alone_and_leave_the_block_as_it_is() -> None:
    doubles, times = Doubles(), list(range(0, 2 * BLOCK, 2))
    ahead = ComputedAhead(doubles, times)
    for time in times:
        assert [ahead.at(time), ahead.at(time + 1)] == [2 * time, 2 * time + 2]
    assert len(doubles.asked) == 2 * BLOCK


def test_a_time_after_the_last_is_computed() -> None:
    assert ComputedAhead(Doubles(), [1, 2]).at(7) == 14
    assert ComputedAhead(Doubles(), []).at(7) == 14
