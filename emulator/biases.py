"""The bias currents of a DAVIS, and what they set: thresholds, bandwidths, refractory period.

A bias has a coarse code, which selects one of eight currents, each about 8 times the one before
(libcaer's table of coarse currents), and a fine code, which divides that current. The formulas:

- threshold θ = (κ_n/κ_p²)·(C2/C1)·ln(I/I_d), with I of the ON or OFF comparator and I_d of the
  differencing amplifier (Nozaki, Delbruck, IEEE TED 64(8), 2017); κ_n = κ_p = 0.7, C1/C2 = 20;
- bandwidth of the source follower f = I_sf/(2π·U_T·C1), C1 = 131 fF, U_T = 25 mV, which holds
  while the follower is slower than the photoreceptor before it;
- bandwidth of the photoreceptor in bright light, proportional to its bias current PrBp
  (Lichtsteiner 2008: the bias of the photoreceptor's amplifier limits it there); 3 kHz at the
  maker's default code (assumed: Lichtsteiner's value, taken to hold for the DAVIS346 at that code);
- refractory period C·U/I_refr, C = 20 fF, U = 0.8 V.

The constants are those of jAER's estimates for the DAVIS, which its authors call guesses. The
thresholds that they give at the maker's defaults (0.28 and 0.26) are higher than the 0.18 and 0.22
that v2e found for these defaults, and that `SensorConfig` uses.

The default codes are those that libcaer, the maker's library, sends to a DAVIS346. Other programs
send others: a driver for ROS sets OnBn to (6, 200) and PrSFBp to (1, 33), which gives a threshold
of 0.41 and a follower twice as fast.

Biases do not change the noise: the rate of shot noise is a function of illuminance alone
(`emulator.pixel.noise`). In a real pixel, lower thresholds and a wider bandwidth let more noise
through.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Self

from emulator.arguments import check_config
from emulator.config import SensorConfig
from emulator.errors import SensorConfigError
from flybench.checks import Range, check_ranges

COARSE_PA = (11.0, 94.0, 756.0, 6054.0, 48_437.0, 387_500.0, 3_100_000.0, 24_800_000.0)
"""Current of each coarse code [pA] (libcaer)."""

_FINE_STEPS = 255
_THRESHOLD_GAIN = 0.7 / 0.7**2 / 20.0
_THERMAL_V = 0.025
_FOLLOWER_F = 131.167e-15
_RESET_C = 20e-15 * 0.8
_LIMIT_HZ = 3000.0


@dataclass(frozen=True)
class Bias:
    """One bias current.

    Attributes:
        coarse: coarse code, 0 to 7.
        fine: fine code, 0 to 255; 0 gives the current of 1 (assumed, since OffBn is 0 by default
            in the maker's DAVIS240, which works).

    Raises:
        SensorConfigError: a code is outside its range.
    """

    coarse: int
    fine: int

    def __post_init__(self) -> None:
        check_ranges(
            self,
            {
                "coarse": Range(0, 7, remedy="Choose a code; a step is a factor of 8."),
                "fine": Range(0, _FINE_STEPS, remedy="Choose a divisor of the coarse current."),
            },
            SensorConfigError,
        )

    @property
    def current_a(self) -> float:
        """Bias current [A]."""
        return COARSE_PA[self.coarse] * 1e-12 * max(self.fine, 1) / _FINE_STEPS


_PHOTORECEPTOR = Bias(2, 58)
"""Code of PrBp that gives `_LIMIT_HZ` (assumed): libcaer's default."""


@dataclass(frozen=True, kw_only=True)
class Biases:
    """The biases of the event pixels; the defaults are those of libcaer for the DAVIS346.

    Attributes:
        diff: bias of the differencing amplifier (DiffBn).
        on: bias of the ON comparator (OnBn).
        off: bias of the OFF comparator (OffBn).
        photoreceptor: bias of the photoreceptor's amplifier (PrBp).
        follower: bias of the source follower behind the photoreceptor (PrSFBp).
        refractory: bias of the reset (RefrBp).

    Raises:
        SensorConfigError: a value is not a `Bias`; or the ON bias is not above that of the
            differencing amplifier, or the OFF bias not below it, because the pixel would then fire
            without end.
    """

    diff: Bias = Bias(4, 39)
    on: Bias = Bias(5, 255)
    off: Bias = Bias(4, 1)
    photoreceptor: Bias = _PHOTORECEPTOR
    follower: Bias = Bias(1, 16)
    refractory: Bias = Bias(4, 25)

    def __post_init__(self) -> None:
        for each in fields(self):
            bias = getattr(self, each.name)
            if not isinstance(bias, Bias):
                raise SensorConfigError(
                    f"the bias {each.name} is {bias!r}. Allowed is a Bias. Give one, such as "
                    "Bias(5, 255)."
                )
        theta = Range(0.01, 10.0, remedy="Set OnBn well above DiffBn, and OffBn well below it.")
        for name in ("theta_on", "theta_off"):
            theta.check(name, getattr(self, name), SensorConfigError)

    @classmethod
    def preset(cls, name: str) -> Self:
        """Return the maker's defaults for a sensor.

        Args:
            name: `davis346` or `davis240`, which differ in OffBn alone (libcaer).

        Raises:
            SensorConfigError: unknown name.
        """
        known = {"davis346": cls(), "davis240": cls(off=Bias(4, 0))}
        if name not in known:
            raise SensorConfigError(
                f"the preset of the biases is {name!r}. Allowed is one of {', '.join(known)}. "
                "Choose one, or give single biases, such as Biases(on=Bias(5, 255))."
            )
        return known[name]

    @property
    def theta_on(self) -> float:
        """ON threshold [ln units]."""
        return _THRESHOLD_GAIN * math.log(self.on.current_a / self.diff.current_a)

    @property
    def theta_off(self) -> float:
        """OFF threshold, positive [ln units]."""
        return -_THRESHOLD_GAIN * math.log(self.off.current_a / self.diff.current_a)

    @property
    def bandwidth_limit_hz(self) -> float:
        """Cutoff of the photoreceptor in bright light [Hz]."""
        return _LIMIT_HZ * self.photoreceptor.current_a / _PHOTORECEPTOR.current_a

    @property
    def follower_hz(self) -> float:
        """Cutoff of the source follower [Hz]."""
        return self.follower.current_a / (2.0 * math.pi * _THERMAL_V * _FOLLOWER_F)

    @property
    def refractory_us(self) -> float:
        """Refractory period [µs]."""
        return _RESET_C / self.refractory.current_a * 1e6


def with_biases(config: SensorConfig, biases: Biases) -> SensorConfig:
    """Return a sensor with thresholds, bandwidths and refractory period set from bias currents.

    All biases take effect together. Those that are not given are the maker's defaults, which give
    other thresholds and another follower than `SensorConfig` does.

    Args:
        config: all other parameters of the sensor.
        biases: bias currents.

    Returns:
        The configuration, with the refractory period rounded to 1 µs.

    Raises:
        SensorConfigError: an argument has the wrong type, or the biases put a parameter out of its
            range.
    """
    check_config(config)
    if not isinstance(biases, Biases):
        raise SensorConfigError(
            f"the biases are {biases!r}. Allowed is a Biases. Make one, such as "
            "Biases(on=Bias(5, 255)), or Biases() for the maker's defaults."
        )
    return replace(
        config,
        theta_on=biases.theta_on,
        theta_off=biases.theta_off,
        bandwidth_limit_hz=biases.bandwidth_limit_hz,
        follower_hz=biases.follower_hz,
        refractory_us=round(biases.refractory_us),
    )
