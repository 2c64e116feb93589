"""Sensors by name: real chips, an ideal sensor, and the parameters of another emulator.

Sources as in `emulator.config`, and: Posch 2011 = Posch, Matolin, Wohlgenannt, IEEE JSSC 46(1),
2011, "A QVGA 143 dB dynamic range frame-free PWM image sensor" (ATIS); Son 2017 = Son et al., ISSCC
2017, "A 640×480 dynamic vision sensor with a 9µm pixel and 300Meps address-event representation"
(the chip family of the DVXplorer); Finateu 2020 = Finateu et al., ISSCC 2020, "A 1280×720
back-illuminated stacked temporal contrast event-based vision sensor with 4.86µm pixels, 1.066GEPS
readout" (IMX636); Gallego 2022 = Gallego et al., IEEE TPAMI 44(1), 2022, table of event cameras;
libcaer, iniVation's driver; v2e's options `clean` and `noisy` in its code.

All presets of real chips have the lens of this bench, 6 mm f/1.4 (assumed). Where a preset states
nothing else, the pixels are those of the DAVIS346 (assumed): thresholds, mismatch, noise, bandwidth
and refractory period depend on biases, and no source gives them all for the other chips.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal, get_args

from emulator.aps.config import ApsConfig
from emulator.config import SensorConfig
from emulator.errors import SensorConfigError
from emulator.readout.config import UNLIMITED, Lines, ReadoutConfig, ReadoutKind

PresetName = Literal[
    "davis346",
    "davis240",
    "dvs128",
    "atis",
    "dvxplorer",
    "gen31",
    "imx636",
    "ideal",
    "v2e_clean",
    "v2e_noisy",
    "davis346_2026_11",
]
"""Names that `preset` accepts."""

WITHOUT_FRAMES: frozenset[PresetName] = frozenset(
    {"dvs128", "atis", "dvxplorer", "gen31", "imx636"}
)
"""Presets of chips without an APS. The emulator also returns frames for them; ignore those."""


def preset(name: PresetName) -> SensorConfig:
    """Return the configuration of a sensor.

    Args:
        name: `davis346`, the default; `davis240` and `dvs128`, its predecessors; `atis`; the
            `dvxplorer` of iniVation; Prophesee's `gen31` (VGA) and `imx636` (EVK4); `ideal`,
            without noise, mismatch and limits; `v2e_clean` and `v2e_noisy`, the parameters of that
            emulator in this model; `davis346_2026_11`, the default before December 2026.

    Raises:
        SensorConfigError: unknown name.
    """
    if name not in get_args(PresetName):
        raise SensorConfigError(
            f"the preset is {name!r}. Allowed is one of {', '.join(get_args(PresetName))}. Choose "
            "one, or give single parameters to SensorConfig."
        )
    return _PRESETS[name]()


def _davis240() -> SensorConfig:
    """DAVIS240 (Brandli 2014: 240×180, 18.5 µm, mismatch 3.5 %, 12 million events per second).

    Thresholds, noise and frames are assumed to be those of the DAVIS346, which has the same pixel,
    and its bus, too. Assumed: the chip is mounted upright, so that its rows are those of the image.
    """
    return SensorConfig(
        width=240,
        height=180,
        pixel_pitch_um=18.5,
        focal_length_mm=6.0,
        theta_mismatch=0.035,
        readout=ReadoutConfig(lines=Lines.ROWS),
    )


def _dvs128() -> SensorConfig:
    """DVS128 (Lichtsteiner 2008: 128×128, 40 µm, mismatch 2.1 %, 3 kHz at 1 klux).

    Assumed: thresholds and noise of the DAVIS346, since the paper varies its thresholds; a bus of
    one million events per second, as users report, with one word for each row.
    """
    return SensorConfig(
        width=128,
        height=128,
        pixel_pitch_um=40.0,
        focal_length_mm=6.0,
        theta_mismatch=0.021,
        readout=ReadoutConfig(limit_hz=1e6, lines=Lines.ROWS, line_words=1),
    )


def _atis() -> SensorConfig:
    """ATIS (Posch 2011: 304×240, 30 µm).

    Its change detector alone: the exposure measurement that each event starts is not modelled.
    Assumed: the row arbiter and the bus of the DAVIS346, in place of a handshake for every event,
    on an upright chip.
    """
    return SensorConfig(
        width=304,
        height=240,
        pixel_pitch_um=30.0,
        focal_length_mm=6.0,
        readout=ReadoutConfig(lines=Lines.ROWS),
    )


def _dvxplorer() -> SensorConfig:
    """DVXplorer (libcaer: 640×480, semi-synchronous readout; Son 2017: 9 µm).

    The readout is a scan of the whole array with libcaer's default timing; see `ReadoutConfig`.
    """
    return SensorConfig(
        width=640,
        height=480,
        pixel_pitch_um=9.0,
        focal_length_mm=6.0,
        readout=ReadoutConfig(kind=ReadoutKind.SCAN, scan_period_us=194),
    )


def _gen31() -> SensorConfig:
    """Prophesee Gen3.1 (Gallego 2022, Gen3 CD: 640×480, 15 µm, 66 million events per second).

    Assumed: its readout is the row arbiter, with one word for each row.
    """
    return SensorConfig(
        width=640,
        height=480,
        pixel_pitch_um=15.0,
        focal_length_mm=6.0,
        readout=ReadoutConfig(limit_hz=66e6, lines=Lines.ROWS, line_words=1),
    )


def _imx636() -> SensorConfig:
    """Sony IMX636 of the EVK4 (Finateu 2020: 1280×720, 4.86 µm, 1.066 billion events per second).

    Assumed: its readout is the row arbiter, with one word for each row. Its event rate controller
    and its filters are not modelled; a lower `readout.limit_hz` stands for a limited rate.
    """
    return SensorConfig(
        width=1280,
        height=720,
        pixel_pitch_um=4.86,
        focal_length_mm=6.0,
        readout=ReadoutConfig(limit_hz=1.066e9, lines=Lines.ROWS, line_words=1),
    )


def _v2e_clean() -> SensorConfig:
    """v2e's `clean`: thresholds of 0.2 ± 0.02, no bandwidth limit, no noise, no reset time."""
    return replace(SensorConfig.ideal(), theta_on=0.2, theta_off=0.2, theta_mismatch=0.02)


def _v2e_noisy() -> SensorConfig:
    """v2e's `noisy`: thresholds of 0.2 ± 0.05, cutoff 30 Hz, leak 0.1 Hz, shot noise 5 Hz.

    In v2e, shot noise falls to a quarter from dark to bright. Here it is noise that crosses the
    thresholds. Assumed: it has 5 Hz, ON and OFF together, at the lowest light with the full cutoff,
    which is at 1 lux on the chip.
    """
    return SensorConfig(
        theta_on=0.2,
        theta_off=0.2,
        theta_mismatch=0.05,
        bandwidth_hz_per_lux=30.0,
        bandwidth_limit_hz=30.0,
        follower_hz=0.0,
        refractory_us=0,
        leak_hz=0.1,
        leak_hz_per_lux=0.0,
        leak_spread=0.0,
        leak_tail_fraction=0.0,
        noise_sigma=0.0503,
        dark_current_spread=0.0,
        readout=UNLIMITED,
        aps=ApsConfig(),
    )


def _davis346_2026_11() -> SensorConfig:
    """The default before December 2026, to compare results with.

    The shot noise of that sensor fell with the light, from 9.8 Hz in the dark (ON and OFF
    together). Here noise crosses the thresholds. Without a follower, its rate rises with the light
    up to 30 lux on the chip. `noise_sigma` is chosen for about 10 Hz there; at 0.1 lux on the chip
    it gives 0.3 Hz.
    """
    return SensorConfig(
        theta_on=0.18,
        theta_off=0.22,
        theta_mismatch=0.035,
        follower_hz=0.0,
        refractory_us=3,
        leak_hz=0.1,
        leak_hz_per_lux=2.4e-5,
        leak_spread=0.0,
        leak_tail_fraction=0.0,
        noise_sigma=0.0355,
        dark_current_spread=0.0,
        hot_fraction=4e-4,
        readout=ReadoutConfig(kind=ReadoutKind.ROUND_ROBIN, lines=Lines.ROWS, line_words=1),
    )


_PRESETS: dict[PresetName, Callable[[], SensorConfig]] = {
    "davis346": SensorConfig,
    "davis240": _davis240,
    "dvs128": _dvs128,
    "atis": _atis,
    "dvxplorer": _dvxplorer,
    "gen31": _gen31,
    "imx636": _imx636,
    "ideal": SensorConfig.ideal,
    "v2e_clean": _v2e_clean,
    "v2e_noisy": _v2e_noisy,
    "davis346_2026_11": _davis346_2026_11,
}
