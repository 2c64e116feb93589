import numpy as np
import pytest

from sim.motion.band_limited_noise import TONES, BandLimitedNoise, band_limited_noise


def drawn(seed: int = 0, *, rms: float = 0.3, corner_hz: float = 4.0) -> BandLimitedNoise:
    return band_limited_noise(np.random.default_rng(seed), rms=rms, corner_hz=corner_hz)


def test_its_root_mean_square_is_the_configured_one() -> None:
    it = drawn()
    values = np.array([it.value(t_s) for t_s in np.arange(0, 200, 0.011)])
    assert it.rms == pytest.approx(0.3)
    assert np.sqrt(np.mean(values**2)) == pytest.approx(0.3, rel=0.02)
    assert abs(values.mean()) < 0.005


def test_its_rate_is_its_derivative() -> None:
    it, step_s = drawn(), 1e-5
    for t_s in (-0.7, 0.0, 1.3):
        slope = (it.value(t_s + step_s) - it.value(t_s - step_s)) / (2 * step_s)
        assert slope == pytest.approx(it.rate(t_s), rel=1e-5)


def test_its_power_follows_the_stated_spectrum() -> None:
    """∫ df / (1 + (f/f_c)⁴) to f_c is 0.8670 f_c of 1.1107 f_c in all: 78 % lies below it."""
    tones = np.concatenate([drawn(seed).angular_rad_s for seed in range(200)]) / (2 * np.pi)
    assert np.mean(tones < 4.0) == pytest.approx(0.8670 / 1.1107, abs=0.01)
    assert np.mean(tones > 12.0) == pytest.approx((1 / 3**3 / 3) / 1.1107, abs=0.006)
    each = drawn().angular_rad_s
    assert len(each) == TONES
    assert (np.diff(each) > 0).all()


def test_a_seed_gives_the_same_and_another_seed_another() -> None:
    assert drawn(1).value(0.4) == drawn(1).value(0.4)
    assert drawn(1).value(0.4) != drawn(2).value(0.4)


def test_its_rms_rate_is_that_of_its_tones() -> None:
    it = drawn()
    rates = np.array([it.rate(t_s) for t_s in np.arange(0, 100, 0.0031)])
    assert np.sqrt(np.mean(rates**2)) == pytest.approx(it.rms_rate, rel=0.02)
