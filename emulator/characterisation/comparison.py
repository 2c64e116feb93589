"""Whether a published figure is of the sensor that was measured."""

from __future__ import annotations

from dataclasses import replace

from emulator.characterisation import sources
from emulator.characterisation.section import Published, Quantity, Section
from emulator.config import SensorConfig
from emulator.presets import PresetName, preset

DAVIS346, DVS128 = "DAVIS346", "DVS128"
_CHIPS: dict[PresetName, str] = {"davis240": "DAVIS240", "dvs128": DVS128}


def chip_of(config: SensorConfig) -> str | None:
    """Name of the chip that a configuration is, None for one that nobody has built.

    The default sensor counts as the DAVIS346 in any size, as its pixels do not change with it.
    """
    for name, chip in _CHIPS.items():
        if config == preset(name):
            return chip
    default = SensorConfig(width=config.width, height=config.height)
    return DAVIS346 if config == default else None


def compared(section: Section, config: SensorConfig) -> Section:
    """A section that says of each published figure if it is of another sensor than this one.

    The figures that stand beside the default sensor stay as they are: those sources name their
    sensors, and what the defaults were set from.
    """
    chip = chip_of(config)
    if chip == DAVIS346:
        return section
    return replace(section, quantities=[_compared(x, chip) for x in section.quantities])


def _compared(quantity: Quantity, chip: str | None) -> Quantity:
    published = quantity.published
    if published is None or (chip is not None and chip in published.source):
        return quantity
    source = f"{published.source.removesuffix(sources.SET)}; {sources.ANOTHER}"
    return replace(quantity, published=Published(published.value, source, another_sensor=True))
