"""Marks on published figures of other sensors."""

import pytest

from emulator import ApsConfig, SensorConfig, preset
from emulator.characterisation import Quantity, Section, sources
from emulator.characterisation.comparison import chip_of, mark_other_sensors

SECTION = Section(
    "Figures",
    "",
    [
        Quantity("rate out", "Mev/s", 1.0, sources.ARBITER_MEV_S),
        Quantity("mismatch", "%", 2.1, sources.MISMATCH_DVS128),
        Quantity("unpublished", "", 1.0),
    ],
)


@pytest.mark.parametrize(
    ("config", "chip"),
    [
        (SensorConfig(), "DAVIS346"),
        (SensorConfig(width=64, height=48), "DAVIS346"),
        (preset("davis240"), "DAVIS240"),
        (preset("dvs128"), "DVS128"),
        (preset("ideal"), None),
        (SensorConfig(theta_on=0.25), None),
        (SensorConfig(aps=ApsConfig(shutter="rolling")), None),
    ],
)
def test_a_chip_is_identified_by_its_settings(config: SensorConfig, chip: str | None) -> None:
    assert chip_of(config) == chip


def test_the_section_of_the_default_sensor_is_unchanged() -> None:
    assert mark_other_sensors(SECTION, SensorConfig()) is SECTION
    assert "our default is set from it" in sources.ARBITER_MEV_S.source


@pytest.mark.parametrize(
    ("config", "mismatch_too"), [(preset("dvs128"), False), (SensorConfig(theta_on=0.25), True)]
)
def test_figures_of_another_sensor_are_marked(config: SensorConfig, mismatch_too: bool) -> None:
    rate, mismatch, none = (x.published for x in mark_other_sensors(SECTION, config).quantities)
    assert rate is not None
    assert rate.another_sensor
    assert rate.source.endswith("DAVIS346; published for another sensor")
    assert mismatch is not None
    assert mismatch.another_sensor == mismatch_too
    assert none is None
