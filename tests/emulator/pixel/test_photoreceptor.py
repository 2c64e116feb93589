import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from emulator.pixel.photoreceptor import inverse_tau_per_us, lag_after, ramp_pieces


@given(
    lag=st.floats(-3, 3),
    slope=st.floats(-1e-3, 1e-3),
    tau=st.floats(10, 1e5),
    cuts=st.lists(st.floats(1, 1e4), min_size=1, max_size=20),
)
def test_many_steps_give_the_same_as_one(
    lag: float, slope: float, tau: float, cuts: list[float]
) -> None:
    stepped = lag
    for span in cuts:
        stepped = lag_after(stepped, slope, tau, math.exp(-span / tau))
    whole = lag_after(lag, slope, tau, math.exp(-math.fsum(cuts) / tau))
    assert stepped == pytest.approx(whole, rel=1e-9, abs=1e-9)


@given(slope=st.floats(-1e-3, 1e-3), tau=st.floats(100, 1e4))
def test_lag_solves_its_differential_equation(slope: float, tau: float) -> None:
    lag, dt = 0.5, 0.01
    for _ in range(2000):
        lag += dt * (slope - lag / tau)
    assert lag_after(0.5, slope, tau, math.exp(-20.0 / tau)) == pytest.approx(lag, abs=1e-5)


def test_cutoff_is_proportional_to_light_up_to_the_limit() -> None:
    per_lux, limit = 2 * math.pi * 1e-4, 2 * math.pi * 3e-3
    assert inverse_tau_per_us(1.0, per_lux, limit) == pytest.approx(per_lux)
    assert inverse_tau_per_us(0.1, per_lux, limit) == pytest.approx(per_lux / 10)
    assert inverse_tau_per_us(1e5, per_lux, limit) == pytest.approx(limit)


def test_only_ramps_in_dim_light_are_cut() -> None:
    assert ramp_pieces(4.0, 9.0, 3.4) == 1
    assert ramp_pieces(0.0, 0.1, 3.4) == 1
    assert ramp_pieces(0.0, 1.1, 3.4) == 5
