"""Characterisation: the experiments that measure real event cameras, run on the emulator.

Each experiment is one file in `experiments/`. It uses only the public interface of the emulator;
if it uses the causes of events, its docstring states this. `characterise` runs all experiments.
`fit_static` and `fit_ramps` estimate the parameters of a sensor from a recording.
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
