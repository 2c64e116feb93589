"""Published figures of real sensors, each with who measured it and under which conditions.

Only figures that we could read in the source's abstract or data sheet, or that the emulator's own
defaults rest on, stand here. The latter say "our default is set from it": that the emulator meets
them shows that the experiment finds what went in, not that the model is right. They stand beside
any sensor; `emulator.characterisation.comparison` says where they are of another one.
"""

from __future__ import annotations

from emulator.characterisation.section import Published

_LICHTSTEINER = "Lichtsteiner 2008, IEEE JSSC 43(2), DVS128"
_BRANDLI = "Brandli 2014, IEEE JSSC 49(10), DAVIS240"
_JOUBERT = "Joubert 2021, Front. Neurosci. 15, 50×50 pixels"
_MAKER = "iniVation, data sheet of the DAVIS346"
SET = "; our default is set from it"
ANOTHER = "published for another sensor"

THETA_ON = Published(0.18, f"Hu 2021 (v2e), from the DAVIS346 maker's default biases{SET}")
THETA_OFF = Published(0.22, THETA_ON.source)
MISMATCH = Published(3.5, _BRANDLI + SET)
MISMATCH_DVS128 = Published(2.1, _LICHTSTEINER)
DARK_LUX = Published(
    0.017,
    f"{_LICHTSTEINER}: usable to 0.1 lux on the scene through f/1.2; our default has its order",
)
BANDWIDTH_HZ = Published(3000.0, f"{_LICHTSTEINER}, 1 klux on the scene{SET}")
LATENCY_BEST_US = Published(15.0, f"{_LICHTSTEINER}, least, above 1 klux on the chip")
LATENCY_DAVIS240_US = Published(3.0, f"{_BRANDLI}, least, biased for speed")
LATENCY_MAKER_US = Published(20.0, f"{_MAKER}, least")
REFRACTORY_US = Published(
    3.0, f"DAVIS346 maker's default biases, by jAER's estimate of what they give{SET}"
)
DYNAMIC_RANGE_DB = Published(120.0, f"{_LICHTSTEINER}; the maker claims as much for the DAVIS346")
DYNAMIC_RANGE_DAVIS240_DB = Published(130.0, _BRANDLI)
ARBITER_MEV_S = Published(12.0, _MAKER + SET)

BACKGROUND_HZ = {
    0.1: (Published(5.6, _JOUBERT + SET), Published(4.2, _JOUBERT + SET)),
    161.0: (Published(0.104, _JOUBERT + SET), Published(0.0012, _JOUBERT + SET)),
    3000.0: (Published(0.172, _JOUBERT + SET), Published(0.0, _JOUBERT)),
}
"""Background activity of a pixel, ON and OFF [Hz], by light on the chip [lux]."""

LEAK_HZ = Published(0.1, f"Nozaki 2017, IEEE TED 64(8), as taken by v2e{SET}")
LEAK_HZ_PER_KLUX = Published(
    0.024, f"{_JOUBERT}: slope through its ON rates at 161 lux and 3 klux{SET}"
)
LEAK_DOUBLING_K = Published(
    7.0, f"textbooks: leakage of silicon junctions doubles every 6 to 8 K{SET}"
)

APS_ELECTRONS_PER_DN = Published(54.4, f"users' reports: 37 ke⁻ over 680 levels{SET}")
APS_READ_NOISE_E = Published(66.0, f"the reproduced paper: 37 ke⁻ over its 55 dB{SET}")
APS_FULL_WELL_KE = Published(37.0, f"users' reports: no document that we could cite{SET}")
APS_FPN_PERCENT = Published(0.5, _BRANDLI + SET)
APS_DYNAMIC_RANGE_DB = Published(55.0, f"the reproduced paper, DAVIS346{SET}")
APS_DYNAMIC_RANGE_DAVIS240_DB = Published(51.0, _BRANDLI)
