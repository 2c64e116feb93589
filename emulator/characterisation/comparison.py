"""Marks published figures that belong to another sensor than the one measured."""

from __future__ import annotations

from dataclasses import replace

from emulator.characterisation import sources
from emulator.characterisation.section import Published, Quantity, Section
from emulator.config import SensorConfig
from emulator.presets import PresetName, preset

DAVIS346, DVS128 = "DAVIS346", "DVS128"
_CHIPS: dict[PresetName, str] = {"davis240": "DAVIS240", "dvs128": DVS128}


def chip_of(config: SensorConfig) -> str | None:
    """Return the name of the real chip that a configuration describes; None if there is none.

    The default sensor is the DAVIS346 whatever its size, since its pixels do not depend on it.
    """
    for name, chip in _CHIPS.items():
        if config == preset(name):
            return chip
    default = SensorConfig(width=config.width, height=config.height)
    return DAVIS346 if config == default else None


def mark_other_sensors(section: Section, config: SensorConfig) -> Section:
    """Mark each published figure of a section that belongs to another sensor than `config`.

    The section of the default sensor is not changed: its sources name their sensors, and state
    which defaults were set from them.
    """
    chip = chip_of(config)
    if chip == DAVIS346:
        return section
    return replace(section, quantities=[_marked(x, chip) for x in section.quantities])


def _marked(quantity: Quantity, chip: str | None) -> Quantity:
    published = quantity.published
    if published is None or (chip is not None and chip in published.source):
        return quantity
    source = f"{published.source.removesuffix(sources.SETS_DEFAULT)}; {sources.OTHER_SENSOR}"
    return replace(quantity, published=Published(published.value, source, another_sensor=True))
