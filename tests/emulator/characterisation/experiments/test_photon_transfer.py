"""The photon transfer curve recovers the parameters of the frames."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from emulator import ApsConfig, SensorConfig
from emulator.characterisation.experiments import photon_transfer
from emulator.characterisation.experiments.photon_transfer import (
    PhotonTransfer,
    fit_line,
    fixed_pattern_dn,
    measure,
    measure_photon_transfer,
    record_frames,
)


@cache
def of_the_default() -> PhotonTransfer:
    return measure_photon_transfer(SensorConfig(), seed=1)


def test_the_default_parameters_are_recovered() -> None:
    found = of_the_default()
    assert found.electrons_per_dn == pytest.approx(37_000 / 680, rel=0.04)
    assert found.read_noise_e == pytest.approx(66.0, rel=0.06)
    assert found.full_well_e == pytest.approx(37_000, rel=0.04)
    assert found.saturation_dn == pytest.approx(680.0, rel=0.01)
    assert found.dynamic_range_db == pytest.approx(55.0, abs=1.0)
    assert found.fpn_percent == pytest.approx(0.5, rel=0.03)


def test_other_parameters_are_recovered() -> None:
    aps = ApsConfig(
        full_well_e=10_000.0,
        saturation_dn=1000,
        read_noise_e=40.0,
        exposure_us=2000,
        fixed_pattern=0.02,
    )
    found = measure_photon_transfer(SensorConfig(aps=aps), seed=1)
    assert found.electrons_per_dn == pytest.approx(10.0, rel=0.04)
    assert found.read_noise_e == pytest.approx(40.0, rel=0.06)
    assert found.fpn_percent == pytest.approx(2.0, rel=0.05)


def test_frames_without_noise_give_no_gain() -> None:
    found = measure_photon_transfer(SensorConfig.noise_free(), seed=1)
    assert found.electrons_per_dn is None
    assert found.read_noise_e is None
    assert found.full_well_e is None
    assert found.dynamic_range_db is None


def test_the_fixed_pattern_excludes_temporal_noise() -> None:
    rng = np.random.default_rng(1)
    pattern = rng.normal(300.0, 4.0, (50, 50))
    stack = np.rint(pattern + rng.normal(0.0, 6.0, (30, 50, 50))).astype(np.uint16)
    assert fixed_pattern_dn(stack) == pytest.approx(4.0, rel=0.05)
    assert fixed_pattern_dn(np.rint(rng.normal(300.0, 6.0, (30, 50, 50))).astype(np.uint16)) < 0.5


def test_the_line_of_known_noise_is_recovered() -> None:
    mean = np.linspace(10.0, 900.0, 30)
    per_dn, read_e = fit_line(mean, 4.0 + mean / 50.0, saturation_dn=1000.0, dark_dn=0.0)
    assert per_dn == pytest.approx(50.0)
    assert read_e == pytest.approx(100.0)


def test_frames_have_a_fixed_exposure() -> None:
    config = replace(SensorConfig(), aps=ApsConfig(exposure_us=1000))
    dim, bright = (
        record_frames(config, chip_lux=lux, number=1, seed=1).mean() for lux in (20.0, 40.0)
    )
    assert bright / dim == pytest.approx(2.0, rel=0.02)


def test_exposures_longer_than_the_usual_period_work() -> None:
    config = replace(SensorConfig(), aps=ApsConfig(exposure_us=10_000_000))
    assert record_frames(config, chip_lux=0.001, number=3, seed=1).shape[0] == 3


def test_the_section_compares_every_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        photon_transfer, "measure_photon_transfer", lambda *_, **__: of_the_default()
    )
    section = measure(SensorConfig(), seed=1)
    assert all(quantity.published is not None for quantity in section.quantities)
