"""Thresholds, mismatch and dark current are recovered from the S-curves."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr

from emulator import SensorConfig
from emulator.characterisation.bench import SCENE_LUX
from emulator.characterisation.experiments.s_curve import (
    fit_dark_lux,
    fit_s_curve,
    measure,
    measure_s_curve,
    response_share,
)
from tests.emulator.characterisation.plain_sensor import PLAIN, QUIET

BRIGHT_LUX = 1000.0


@pytest.mark.parametrize(
    ("on", "theta", "mismatch"), [(True, 0.18, 0.035), (False, 0.22, 0.035), (True, 0.3, 0.02)]
)
def test_threshold_and_mismatch_are_recovered(on: bool, theta: float, mismatch: float) -> None:
    config = replace(PLAIN, theta_mismatch=mismatch)
    config = replace(config, theta_on=theta) if on else replace(config, theta_off=theta)
    curve = measure_s_curve(config, chip_lux=BRIGHT_LUX, on=on, seed=3)
    assert curve.threshold == pytest.approx(theta, rel=0.02)
    assert curve.mismatch == pytest.approx(mismatch, rel=0.1)
    assert curve.guess < 0.01


def test_without_mismatch_the_curve_is_a_step_at_the_threshold() -> None:
    config = replace(QUIET, theta_mismatch=0.0)
    curve = measure_s_curve(config, chip_lux=BRIGHT_LUX, on=True, seed=1)
    assert curve.threshold == pytest.approx(0.18, rel=0.03)
    assert curve.mismatch is not None
    assert curve.mismatch < 0.01
    assert set(np.unique(curve.probability)) <= {0.0, 1.0}


@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_dark_current_hides_part_of_a_step(ratio: float) -> None:
    config = replace(QUIET, dark_lux=0.1)
    lux = 0.1 / ratio
    curve = measure_s_curve(config, chip_lux=lux, on=True, seed=2)
    assert curve.threshold == pytest.approx(np.log1p((1.0 + ratio) * np.expm1(0.18)), rel=0.03)


def test_near_darkness_no_step_down_is_seen() -> None:
    config = SensorConfig.noise_free()
    curve = measure_s_curve(config, chip_lux=0.001, on=False, seed=2)
    assert curve.threshold is None
    assert curve.mismatch is None


def test_control_columns_show_the_noise() -> None:
    contrast = np.zeros(8)
    share, guess = response_share(
        replace(PLAIN, noise_sigma=0.08), contrast, chip_lux=0.1, on=True, seed=1, height=400
    )
    assert guess == pytest.approx(share.mean(), abs=0.04)
    assert guess > 0.05
    quiet, none = response_share(
        SensorConfig.noise_free(), contrast, chip_lux=0.1, on=True, seed=1, height=20
    )
    assert none == quiet.max() == 0.0


def test_the_fit_recovers_the_parameters_of_a_curve() -> None:
    c = np.linspace(0.02, 0.6, 60)
    curve = fit_s_curve(c, 0.2 + 0.7 * ndtr((c - 0.25) / 0.05), 0.2)
    assert curve.threshold == pytest.approx(0.25, rel=0.01)
    assert curve.mismatch == pytest.approx(0.05, rel=0.02)
    assert curve.lapse == pytest.approx(0.1, abs=0.01)


def test_the_dark_current_is_recovered_from_thresholds() -> None:
    lux = np.array([0.1, 1.0, 10.0, 100.0])
    theta = np.log1p((1.0 + 0.03 / lux) * np.expm1(0.2))
    assert fit_dark_lux(lux, theta) == pytest.approx(0.03, rel=1e-6)
    theta[:2] = np.nan
    assert fit_dark_lux(lux, theta) is None


def test_section_of_the_default_sensor() -> None:
    section = measure(SensorConfig(), seed=5)
    found = {quantity.name: quantity for quantity in section.quantities}
    for name, theta in (("ON threshold at 1 klux", 0.28), ("OFF threshold at 1 klux", 0.35)):
        measured = found[name].measured
        assert measured is not None
        assert 0.88 * theta < measured < theta  # noise carries pixels across earlier
    dark = found["dark current as illuminance on the chip"]
    assert dark.measured == pytest.approx(0.01, rel=0.4)
    labels = {series.label for series in section.plots[0].series}
    assert len(labels - {""}) == len(SCENE_LUX)
