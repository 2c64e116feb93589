"""Published figures of real sensors, with the source and the conditions of each.

A figure is listed here if we could read it in the abstract or data sheet of its source, or if a
default of the emulator is set from it. The latter say "our default is set from it". Agreement with
such a figure shows that the experiment recovers its input, not that the model is right. The figures
are shown beside any sensor; `emulator.characterisation.comparison` marks those that belong to
another sensor.
"""

from __future__ import annotations

from emulator.characterisation.section import Published

_LICHTSTEINER = "Lichtsteiner 2008, IEEE JSSC 43(2), DVS128"
_BRANDLI = "Brandli 2014, IEEE JSSC 49(10), DAVIS240"
_JOUBERT = "Joubert 2021, Front. Neurosci. 15, 50×50 pixels"
_MAKER = "iniVation, data sheet of the DAVIS346"
SETS_DEFAULT = "; our default is set from it"
OTHER_SENSOR = "published for another sensor"

THETA_ON = Published(
    0.18, f"Hu 2021 (v2e), from the default biases of the DAVIS346's maker{SETS_DEFAULT}"
)
THETA_OFF = Published(0.22, THETA_ON.source)
MISMATCH = Published(3.5, _BRANDLI + SETS_DEFAULT)
MISMATCH_DVS128 = Published(2.1, _LICHTSTEINER)
DARK_LUX = Published(
    0.017,
    f"{_LICHTSTEINER}: usable down to 0.1 lux on the scene at f/1.2; our default is of this order",
)
BANDWIDTH_HZ = Published(3000.0, f"{_LICHTSTEINER}, 1 klux on the scene{SETS_DEFAULT}")
LATENCY_BEST_US = Published(15.0, f"{_LICHTSTEINER}, minimum, above 1 klux on the chip")
LATENCY_DAVIS240_US = Published(3.0, f"{_BRANDLI}, minimum, biased for speed")
LATENCY_MAKER_US = Published(20.0, f"{_MAKER}, minimum")
REFRACTORY_US = Published(
    3.0, f"jAER's estimate for the default biases of the DAVIS346's maker{SETS_DEFAULT}"
)
DYNAMIC_RANGE_DB = Published(
    120.0, f"{_LICHTSTEINER}; the maker states the same value for the DAVIS346"
)
DYNAMIC_RANGE_DAVIS240_DB = Published(130.0, _BRANDLI)
ARBITER_MEV_S = Published(12.0, _MAKER + SETS_DEFAULT)

_LAB = (
    "our analysis of a recording of a DAVIS346, `example/davis.aedat4` of aestream at a1a695e: "
    "the 19 windows of 100 µs with at least 4 Mev/s, along the columns"
)
EVENTS_PER_LINE = Published(1.043, _LAB)
LINES_PER_STAMP = Published(3.98, _LAB)
NEIGHBOUR_LINES = Published(41.4, f"{_LAB}; 5.6 % if the columns are shuffled")
NEAR_LINES = Published(67.0, f"{_LAB}; 14.8 % if the columns are shuffled")
FORWARD_MOVES = Published(63.6, f"{_LAB}; 53.8 % of the steps in the order of the file")

_LAMP = (
    "our analysis of a recording of a DAVIS346, `example/davis.aedat4` of aestream at a1a695e: "
    "the 197 pixels with more than 600 ON events per second"
)
LAMP_ON_HZ = Published(745.0, _LAMP)
LAMP_OFF_HZ = Published(169.0, _LAMP)
LAMP_ON_VARIATION = Published(0.39, _LAMP)

BACKGROUND_HZ = {
    0.1: (Published(5.6, _JOUBERT + SETS_DEFAULT), Published(4.2, _JOUBERT + SETS_DEFAULT)),
    161.0: (Published(0.104, _JOUBERT + SETS_DEFAULT), Published(0.0012, _JOUBERT + SETS_DEFAULT)),
    3000.0: (Published(0.172, _JOUBERT + SETS_DEFAULT), Published(0.0, _JOUBERT)),
}
"""ON and OFF background activity of a pixel [Hz], by illuminance on the chip [lux]."""

LEAK_HZ = Published(0.1, f"Nozaki 2017, IEEE TED 64(8), as used in v2e{SETS_DEFAULT}")
LEAK_HZ_PER_KLUX = Published(
    0.024, f"{_JOUBERT}: slope between its ON rates at 161 lux and 3 klux{SETS_DEFAULT}"
)
LEAK_DOUBLING_K = Published(
    7.0, f"textbooks: leakage of silicon junctions doubles every 6 to 8 K{SETS_DEFAULT}"
)

APS_ELECTRONS_PER_DN = Published(54.4, f"users' reports: 37 ke⁻ over 680 levels{SETS_DEFAULT}")
APS_READ_NOISE_E = Published(66.0, f"the reproduced paper: 37 ke⁻ over its 55 dB{SETS_DEFAULT}")
APS_FULL_WELL_KE = Published(37.0, f"users' reports; we found no document to cite{SETS_DEFAULT}")
APS_FPN_PERCENT = Published(0.5, _BRANDLI + SETS_DEFAULT)
APS_DYNAMIC_RANGE_DB = Published(55.0, f"the reproduced paper, DAVIS346{SETS_DEFAULT}")
APS_DYNAMIC_RANGE_DAVIS240_DB = Published(51.0, _BRANDLI)
