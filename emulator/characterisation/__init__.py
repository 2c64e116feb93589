"""The emulator on the test bench: the experiments with which real event cameras are characterised.

Each experiment is a file; each uses nothing of the emulator but what any user can, and looks at
causes only where it says so. `characterise` runs them all; `fit_static` and `fit_ramps` go the
other way, from a recording to the sensor's parameters.
"""

from emulator.characterisation.datasheet import EXPERIMENTS, Datasheet, characterise
from emulator.characterisation.ramp_fit import Thresholds, fit_ramps
from emulator.characterisation.section import (
    Plot,
    Published,
    Quantity,
    Section,
    Series,
    Style,
)
from emulator.characterisation.static_fit import StaticFit, fit_static

__all__ = [
    "EXPERIMENTS",
    "Datasheet",
    "Plot",
    "Published",
    "Quantity",
    "Section",
    "Series",
    "StaticFit",
    "Style",
    "Thresholds",
    "characterise",
    "fit_ramps",
    "fit_static",
]
