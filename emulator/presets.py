"""Sensors by name: real ones, the textbook's, and another emulator's in our model.

Sources as in `emulator.config`; v2e's figures are those of its options `clean` and `noisy` (Hu,
Liu, Delbruck, CVPRW 2021, and its code).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, get_args

from emulator.aps.config import ApsConfig
from emulator.config import UNLIMITED_HZ, SensorConfig
from emulator.errors import SensorConfigError
from emulator.pixel.noise import SHOT_OFF_HZ, SHOT_ON_PER_OFF

PresetName = Literal["davis346", "davis240", "dvs128", "ideal", "v2e_clean", "v2e_noisy"]
"""Names that `preset` knows."""

WITHOUT_FRAMES: frozenset[PresetName] = frozenset({"dvs128"})
"""Those of chips that give events only; the emulator's frames of them are to be left."""

_NO_LIMIT_HZ_PER_LUX = 1e15
_V2E_SHOT_HZ = 5.0


def preset(name: PresetName) -> SensorConfig:
    """The sensor of that name.

    Args:
        name: `davis346`, the default; `davis240` and `dvs128`, its forebears; `ideal`, without
            noise, mismatch and limits; `v2e_clean` and `v2e_noisy`, that emulator's parameters
            in our model.

    Raises:
        SensorConfigError: another name.
    """
    if name not in get_args(PresetName):
        raise SensorConfigError(
            f"the preset is {name!r}; allowed is one of {', '.join(get_args(PresetName))}; "
            "give single parameters to SensorConfig instead"
        )
    return {
        "davis346": SensorConfig,
        "davis240": _davis240,
        "dvs128": _dvs128,
        "ideal": SensorConfig.ideal,
        "v2e_clean": _v2e_clean,
        "v2e_noisy": _v2e_noisy,
    }[name]()


def _davis240() -> SensorConfig:
    """DAVIS240 (Brandli 2014: 240×180, 18.5 µm, mismatch 3.5 %, 12 million events a second).

    Thresholds, noise and frames are taken to be those of the DAVIS346, which has the same pixel.
    """
    return SensorConfig(width=240, height=180, theta_mismatch=0.035, readout_limit_hz=12e6)


def _dvs128() -> SensorConfig:
    """DVS128 (Lichtsteiner 2008: 128×128, mismatch 2.1 %, 3 kHz at 1 klux).

    Assumed: thresholds and noise of the DAVIS346, since the paper varies its thresholds; a bus of
    one million events a second, as users report. It has no frames: those it gives are to be left.
    """
    return SensorConfig(width=128, height=128, theta_mismatch=0.021, readout_limit_hz=1e6)


def _v2e_clean() -> SensorConfig:
    """v2e's `clean`: thresholds of 0.2 ± 0.02, no bandwidth limit, no noise, no reset time."""
    return replace(SensorConfig.ideal(), theta_on=0.2, theta_off=0.2, theta_mismatch=0.02)


def _v2e_noisy() -> SensorConfig:
    """v2e's `noisy`: thresholds of 0.2 ± 0.05, cutoff 30 Hz, leak 0.1 Hz, shot noise 5 Hz.

    Its shot noise falls to a quarter from dark to bright; here it follows the published law, and
    has the 5 Hz, ON and OFF together, in the dark.
    """
    dark_hz = SHOT_OFF_HZ[0] * (1.0 + SHOT_ON_PER_OFF)
    return SensorConfig(
        theta_on=0.2,
        theta_off=0.2,
        theta_mismatch=0.05,
        bandwidth_hz_per_lux=_NO_LIMIT_HZ_PER_LUX,
        bandwidth_limit_hz=30.0,
        refractory_us=0,
        leak_hz=0.1,
        leak_hz_per_lux=0.0,
        shot_noise_scale=_V2E_SHOT_HZ / dark_hz,
        hot_fraction=0.0,
        readout_limit_hz=UNLIMITED_HZ,
        aps=ApsConfig(),
    )
