import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.errors import SceneConfigError
from sim.motion.trajectory import Profile, Trajectory

OMEGA = st.floats(0.1, 3.0)
DISTANCE = st.floats(3.0, 12.0)
STEP_S = 1e-5


@given(OMEGA, DISTANCE, st.sampled_from(Profile), st.floats(-0.4, 0.4))
def test_speed_is_the_derivative_of_position(
    omega: float, distance: float, profile: Profile, t_s: float
) -> None:
    path = Trajectory(omega, distance, profile)
    slope = (path.position_m(t_s + STEP_S) - path.position_m(t_s - STEP_S)) / (2 * STEP_S)
    assert slope == pytest.approx(path.speed_m_s(t_s), rel=1e-4)


@given(OMEGA, DISTANCE, st.sampled_from(Profile), st.floats(-0.4, 0.4))
def test_angular_velocity_is_the_derivative_of_the_bearing(
    omega: float, distance: float, profile: Profile, t_s: float
) -> None:
    path = Trajectory(omega, distance, profile)

    def bearing(at_s: float) -> float:
        return math.atan2(path.position_m(at_s), distance)

    slope = (bearing(t_s + STEP_S) - bearing(t_s - STEP_S)) / (2 * STEP_S)
    assert slope == pytest.approx(path.angular_velocity_rad_s(t_s), rel=1e-4)


@given(OMEGA, DISTANCE, st.sampled_from(Profile))
def test_omega_is_that_of_closest_approach(omega: float, distance: float, profile: Profile) -> None:
    assert Trajectory(omega, distance, profile).angular_velocity_rad_s(0) == pytest.approx(omega)


def test_only_constant_omega_keeps_the_angular_velocity() -> None:
    held = Trajectory(1.61, 6.89, Profile.CONSTANT_OMEGA)
    free = Trajectory(1.61, 6.89)
    assert held.angular_velocity_rad_s(0.3) == pytest.approx(1.61)
    assert free.angular_velocity_rad_s(0.3) < 1.4
    assert free.speed_m_s(0.3) == free.speed_m_s(0)


@given(OMEGA, DISTANCE, st.sampled_from(Profile), st.floats(-5, 5))
def test_time_is_the_inverse_of_position(
    omega: float, distance: float, profile: Profile, distances: float
) -> None:
    path, position_m = Trajectory(omega, distance, profile), distances * distance  # to 79°
    assert path.position_m(path.time_at_s(position_m)) == pytest.approx(position_m, abs=1e-9)


def test_a_bearing_beyond_the_profile_is_refused() -> None:
    with pytest.raises(SceneConfigError, match="bearing"):
        Trajectory(1.61, 6.89, Profile.CONSTANT_OMEGA).position_m(0.9)
