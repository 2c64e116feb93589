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
JOUBERT = "Joubert 2021, Front. Neurosci. 15, 50×50 pixels"
_MAKER = "iniVation, data sheet of the DAVIS346"
_CODES = "the maker's bias codes of the DAVIS346, converted by `emulator.biases`"
_CRADLE = "our analysis of a clip of a DAVIS346 (cradle, docs/explanation/real-recordings.md)"
SETS_DEFAULT = "; our default is set from it"
OTHER_SENSOR = "published for another sensor"

THETA_ON = Published(0.283, _CODES + SETS_DEFAULT)
THETA_OFF = Published(0.262, f"{_CODES}; our default follows the ratio of ON to OFF events")
THRESHOLD_RATIO = Published(1.25, f"{_CRADLE}: ON over OFF events on the dark floor{SETS_DEFAULT}")
THRESHOLD_RATIO_JOUBERT = Published(1.33, f"{JOUBERT}: ON over OFF events at 0.1 lux")
MISMATCH = Published(3.5, _BRANDLI)
MISMATCH_JOUBERT = Published(
    2.4, f"{JOUBERT}: scatter of ln(ON/OFF) at 0.1 lux, 8.5 % of the threshold{SETS_DEFAULT}"
)
MISMATCH_DVS128 = Published(2.1, _LICHTSTEINER)
DARK_LUX = Published(
    0.017,
    f"{_LICHTSTEINER}: usable down to 0.1 lux on the scene at f/1.2; our default is of this order",
)
BANDWIDTH_HZ = Published(
    3000.0, f"{_LICHTSTEINER}, 1 klux on the scene; the limit of our photoreceptor is set from it"
)
FOLLOWER_HZ = Published(286.0, f"{_CODES}: cutoff of the source follower{SETS_DEFAULT}")
LATENCY_BEST_US = Published(15.0, f"{_LICHTSTEINER}, minimum, above 1 klux on the chip")
LATENCY_DAVIS240_US = Published(3.0, f"{_BRANDLI}, minimum, biased for speed")
LATENCY_MAKER_US = Published(20.0, f"{_MAKER}, minimum")
DYNAMIC_RANGE_DB = Published(
    120.0, f"{_LICHTSTEINER}; the maker states the same value for the DAVIS346"
)
DYNAMIC_RANGE_DAVIS240_DB = Published(130.0, _BRANDLI)
ARBITER_MEV_S = Published(12.0, _MAKER + SETS_DEFAULT)

_LAB = (
    "our analysis of a recording of a DAVIS346, `example/davis.aedat4` of aestream at a1a695e: "
    "the 19 windows of 100 µs with at least 4 Mev/s, along the columns"
)
REFRACTORY_US = Published(
    270.0,
    "our analysis of a recording of a DAVIS346, `example/davis.aedat4` of aestream at a1a695e: one "
    f"of 97,445 intervals of a pixel is below 250 µs, 272 are from 250 to 300 µs{SETS_DEFAULT}",
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

JOUBERT_LUX = (0.1, 161.0, 3000.0)
"""Illuminances of the recordings of Joubert 2021, on the chip or on the scene [lux]."""
CRADLE_LUX = (0.001, 0.46, 2.2)
"""Illuminances of three areas of cradle, from its frames, whose dark floor reads 0 [lux]."""
_FLOOR = f"{_CRADLE}: dark floor, 8,304 pixels for 0.51 s; noise and dark spread are set from it"
_STRIP = f"{_CRADLE}: 696 pixels for 0.51 s, 5 events"
_WALL = f"{_CRADLE}: bright wall at 1.7 to 2.6 lux, 15,400 pixels for 0.51 s"
BACKGROUND_HZ = {
    0.001: (Published(0.200, _FLOOR), Published(0.160, _FLOOR)),
    0.1: (Published(6.34, JOUBERT), Published(4.76, JOUBERT)),
    0.46: (Published(0.006, _STRIP), Published(0.008, _STRIP)),
    2.2: (
        Published(0.004, f"{_WALL}: 0.003 to 0.005 Hz"),
        Published(0.0045, f"{_WALL}: 0.002 to 0.007 Hz"),
    ),
    161.0: (
        Published(0.095, f"{JOUBERT}: 0.086 to 0.104 Hz"),
        Published(0.0008, f"{JOUBERT}: 0.0003 to 0.0012 Hz"),
    ),
    3000.0: (Published(0.166, f"{JOUBERT}: 0.159 to 0.172 Hz"), Published(0.0, JOUBERT)),
}
"""ON and OFF background activity of a pixel [Hz], by illuminance on the chip [lux]."""

ON_QUANTILES_HZ = {
    5: Published(2.06, f"{JOUBERT}, 0.1 lux"),
    50: Published(5.6, f"{JOUBERT}, 0.1 lux"),
    95: Published(12.4, f"{JOUBERT}, 0.1 lux"),
}
INTERVALS_PERCENT = {
    161.0: (66.0, 19.2, 6.5, 2.6, 1.4),
    3000.0: (5.4, 22.2, 37.3, 19.2, 7.0),
}
"""Share of the pixels with 0, 1, 2, 3 and 4 intervals between ON events in the recordings of
Joubert 2021 [%], by illuminance [lux]."""
RECORDED_S = {161.0: 17.5, 3000.0: 20.0}
"""Length of these recordings [s]. It is not published. It is chosen to fit the intervals of every
pixel with three or more of them (16 to 19 s, and 19 to 21.5 s)."""
LN_RATE_DEVIATION = (
    Published(0.55, f"{JOUBERT}, 0.1 lux"),
    Published(0.59, f"{JOUBERT}, 0.1 lux"),
)
"""Standard deviation over the pixels of ln(ON rate) and of ln(OFF rate)."""
LN_RATIO_MEAN = Published(0.30, f"{JOUBERT}, 0.1 lux")
LN_RATIO_DEVIATION = Published(0.13, f"{JOUBERT}, 0.1 lux; the mismatch is set from it")
INTERVAL_VARIATION = (
    Published(0.89, f"{JOUBERT}, 0.1 lux"),
    Published(0.79, f"{JOUBERT}, 0.1 lux"),
)
"""Coefficient of variation of the intervals of a pixel between ON events, and OFF events."""
HOT_PERCENT = Published(0.08, f"{JOUBERT}: two pixels, at 45 and 18 Hz")
SILENT_PERCENT = Published(88.0, f"{_CRADLE}: dark floor")
FANO = Published(2.2, f"{_CRADLE}: dark floor")
ALTERNATION_PERCENT = Published(73.0, f"{_CRADLE}: dark floor")

LEAK_HZ = Published(
    0.05, f"{JOUBERT}: 0.055 Hz at 161 lux in the median pixel, less what light adds{SETS_DEFAULT}"
)
LEAK_HZ_NOZAKI = Published(0.1, "Nozaki 2017, IEEE TED 64(8), as used in v2e")
LEAK_HZ_PER_KLUX = Published(
    0.0247, f"{JOUBERT}: 0.055 Hz at 161 lux and 0.125 Hz at 3 klux, median pixel{SETS_DEFAULT}"
)
LEAK_SPREAD = (
    Published(0.45, f"{JOUBERT}, 161 lux: nine tenths of the pixels; our default is between"),
    Published(0.3, f"{JOUBERT}, 3 klux: nine tenths of the pixels; our default is between"),
)
"""Standard deviation of ln(leak) over the pixels, at 161 lux and at 3 klux."""
LEAK_DOUBLING_K = Published(
    7.0, f"textbooks: leakage of silicon junctions doubles every 6 to 8 K{SETS_DEFAULT}"
)

APS_ELECTRONS_PER_DN = Published(54.4, f"users' reports: 37 ke⁻ over 680 levels{SETS_DEFAULT}")
APS_READ_NOISE_E = Published(66.0, f"the reproduced paper: 37 ke⁻ over its 55 dB{SETS_DEFAULT}")
APS_FULL_WELL_KE = Published(37.0, f"users' reports; we found no document to cite{SETS_DEFAULT}")
APS_FPN_PERCENT = Published(0.5, _BRANDLI + SETS_DEFAULT)
APS_DYNAMIC_RANGE_DB = Published(55.0, f"the reproduced paper, DAVIS346{SETS_DEFAULT}")
APS_DYNAMIC_RANGE_DAVIS240_DB = Published(51.0, _BRANDLI)
