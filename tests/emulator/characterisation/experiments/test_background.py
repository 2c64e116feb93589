"""Background activity agrees with the published figures, and its causes add up."""

from dataclasses import replace

import pytest

from emulator import SensorConfig
from emulator.characterisation.experiments.background import (
    measure,
    measure_background,
    record_static,
)
from flybench.events import Cause


@pytest.mark.parametrize(("lux", "on_hz", "off_hz"), [(0.1, 5.6, 4.2), (161.0, 0.104, 0.0012)])
def test_rates_agree_with_the_published_ones(lux: float, on_hz: float, off_hz: float) -> None:
    config = SensorConfig()
    found = measure_background(record_static(config, chip_lux=lux, seed=2), chip_lux=lux)
    assert found.on_hz == pytest.approx(on_hz, rel=0.08)
    assert found.off_hz == pytest.approx(off_hz, rel=0.1)
    assert found.by_cause_hz[Cause.SIGNAL] == 0.0


def test_causes_can_be_switched_off_separately() -> None:
    config = replace(SensorConfig(), hot_fraction=0.0, leak_hz=0.0, leak_hz_per_lux=0.0)
    found = measure_background(record_static(config, chip_lux=0.5, seed=2), chip_lux=0.5)
    assert found.by_cause_hz[Cause.LEAK] == found.by_cause_hz[Cause.HOT] == 0.0
    assert found.by_cause_hz[Cause.SHOT] == pytest.approx(found.on_hz + found.off_hz, rel=1e-6)
    assert found.hot_share == 0.0


def test_section_of_the_default_sensor() -> None:
    section = measure(SensorConfig(), seed=3)
    compared = [q for q in section.quantities if q.difference is not None]
    assert len(compared) == 5
    assert max(abs(q.difference or 0.0) for q in compared) < 0.12
    assert {series.label for series in section.plots[1].series} >= {"leak", "shot"}
