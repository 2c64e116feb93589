import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.motion.sample_times import sample_times_us


@given(st.floats(10, 5000), st.floats(0.1, 4), st.integers(1000, 20_000))
def test_no_step_moves_farther_or_lasts_longer_than_allowed(
    speed: float, step_px: float, max_step_us: int
) -> None:
    times = np.array(
        list(sample_times_us(0, 200_000, lambda _: speed, step_px=step_px, max_step_us=max_step_us))
    )
    steps = np.diff(times)
    assert times[0] == 0
    assert times[-1] == 200_000
    assert (steps > 0).all()
    assert steps.max() <= max_step_us
    assert steps.max() * 1e-6 * speed <= step_px + 1e-9


def test_an_empty_road_has_few_samples_and_an_entering_object_is_not_missed() -> None:
    def speed(t_us: int) -> float:
        return 500.0 if 52_000 <= t_us < 62_000 else 0.0

    times = np.array(list(sample_times_us(0, 100_000, speed, step_px=0.5, max_step_us=5000)))
    assert times.size == pytest.approx(10 + 15 + 8, abs=3)
    moving = (times[1:] > 52_000) & (times[:-1] < 62_000)
    assert np.diff(times)[moving].max() <= 1000
