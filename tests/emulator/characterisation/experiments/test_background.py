"""Background activity: its rates by illuminance, and its causes."""

from dataclasses import replace

import pytest

from emulator import SensorConfig
from emulator.characterisation import sources
from emulator.characterisation.experiments.background import (
    CHIP_PER_SCENE,
    measure,
    measure_background,
    record_static,
    scene_reading,
)
from flybench.events import Cause
from tests.emulator.characterisation.plain_sensor import PLAIN, QUIET


def test_leak_gives_on_events_at_its_rate() -> None:
    config = replace(PLAIN, theta_mismatch=0.0)
    found = measure_background(record_static(config, chip_lux=161.0, seed=2), chip_lux=161.0)
    assert found.on_hz == pytest.approx(0.1 + 161.0 * 2.4e-5, rel=0.05)
    assert found.off_hz == 0.0
    assert found.by_cause_hz[Cause.LEAK] == pytest.approx(found.on_hz)


def test_without_leak_the_thresholds_set_the_ratio_of_the_rates() -> None:
    """θ_on·R_on = θ_off·R_off in a pixel that resets to what it sees."""
    config = replace(QUIET, noise_sigma=0.05, theta_mismatch=0.0)
    found = measure_background(record_static(config, chip_lux=0.5, seed=2), chip_lux=0.5)
    assert found.by_cause_hz[Cause.LEAK] == found.by_cause_hz[Cause.HOT] == 0.0
    assert sum(found.by_cause_hz.values()) == pytest.approx(found.on_hz + found.off_hz, rel=1e-6)
    assert found.by_cause_hz[Cause.SIGNAL] == 0.0
    assert 0.18 * found.on_hz == pytest.approx(0.22 * found.off_hz, rel=0.03)
    assert found.hot_share == 0.0


def test_the_other_reading_gives_the_same_sensor_for_illuminance_on_the_scene() -> None:
    config = SensorConfig()
    other = scene_reading(config)
    assert other.bandwidth_hz_per_lux * CHIP_PER_SCENE == pytest.approx(config.bandwidth_hz_per_lux)
    assert other.leak_hz_per_lux * CHIP_PER_SCENE == pytest.approx(config.leak_hz_per_lux)
    assert (
        replace(
            other,
            bandwidth_hz_per_lux=config.bandwidth_hz_per_lux,
            leak_hz_per_lux=config.leak_hz_per_lux,
        )
        == config
    )
    assert scene_reading(SensorConfig.ideal()) == SensorConfig.ideal()  # it has no limit


def test_section_of_the_default_sensor() -> None:
    section = measure(SensorConfig(), seed=3)
    assert len(section.quantities) == 2 * (6 + 6) + 1
    figures = section.figures
    for lux in ("161 lux", "3 klux"):
        on = figures[f"ON events at {lux} on the chip"]
        assert on.difference is not None
        assert abs(on.difference) < 0.6
    dark, dim, bright = (
        figures[f"OFF events at {lux} on the chip"].measured
        for lux in ("0.001 lux", "0.1 lux", "161 lux")
    )
    assert dark is not None
    assert dim is not None
    assert bright is not None
    assert bright < dark < dim
    for polarity, factor in (("ON", 0.5), ("OFF", 0.1)):  # the other reading has much less noise
        names = [f"{polarity} events at 0.46 lux on the chip{x}" for x in ("", ", other reading")]
        chip, scene = (figures[name].measured for name in names)
        assert chip is not None
        assert scene is not None
        assert scene < factor * chip
    published = {series.label for series in section.plots[0].series}
    assert published >= {"Joubert 2021, ON", "DAVIS346 clip, OFF", "OFF, other reading"}
    assert {series.label for series in section.plots[1].series} >= {"leak", "shot"}
    assert set(sources.JOUBERT_LUX) | set(sources.CRADLE_LUX) == set(sources.BACKGROUND_HZ)
