"""Bias currents, as a DAVIS takes them, and what they set: thresholds, bandwidth, reset.

A bias is a coarse code, a master current halved three times a step, and a fine code that divides
it (libcaer's table of coarse currents). The formulas:

- threshold θ = (κ_n/κ_p²)·(C2/C1)·ln(I/I_d), with I of the ON or OFF comparator and I_d of the
  differencing amplifier (Nozaki, Delbruck, IEEE TED 64(8), 2017); κ_n = κ_p = 0.7, C1/C2 = 20;
- bandwidth of the source follower f = I_sf/(2π·U_T·C1), C1 = 131 fF, U_T = 25 mV, which holds
  while it is slower than the photoreceptor before it;
- bandwidth of the photoreceptor in bright light, in proportion to its bias current PrBp
  (Lichtsteiner 2008: the bias of the receptor's amplifier limits it there); 3 kHz at the maker's
  default code (assumed: Lichtsteiner's figure, taken to hold for the DAVIS346 at that code);
- refractory period C·U/I_refr, C = 20 fF, U = 0.8 V.

The constants are those of jAER's estimates for the DAVIS, which its authors call guesses. The
thresholds that they give at the maker's defaults (0.28 and 0.26) are higher than the 0.18 and 0.22
that v2e found for them, and that our default configuration has.

The default codes are those that libcaer, the maker's library, sends to a DAVIS346. Other programs
send others: a driver for ROS has OnBn (6, 200) and PrSFBp (1, 33), for a threshold of 0.41 and a
follower twice as fast.

No bias touches the noise: the rate of shot noise is a function of light alone
(`emulator.pixel.noise`), where in a real pixel lower thresholds and a wider bandwidth let more
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
        fine: fine code, 0 to 255; 0 is taken to leave one step of current (assumed, since OffBn
            is 0 by default in the maker's DAVIS240, which works).

    Raises:
        SensorConfigError: a code is outside its range.
    """

    coarse: int
    fine: int

    def __post_init__(self) -> None:
        check_ranges(
            self,
            {
                "coarse": Range(0, 7, remedy="Each step is a factor of 8."),
                "fine": Range(0, _FINE_STEPS, remedy="It divides the coarse current."),
            },
            SensorConfigError,
        )

    @property
    def current_a(self) -> float:
        """The current [A]."""
        return COARSE_PA[self.coarse] * 1e-12 * max(self.fine, 1) / _FINE_STEPS


_PHOTORECEPTOR = Bias(2, 58)
"""Code of PrBp at which `_LIMIT_HZ` is taken to hold: libcaer's default; that it gives 3 kHz is
assumed."""


@dataclass(frozen=True, kw_only=True)
class Biases:
    """The biases that shape events; the defaults are those of libcaer for the DAVIS346.

    Attributes:
        diff: of the differencing amplifier (DiffBn).
        on: of the ON comparator (OnBn).
        off: of the OFF comparator (OffBn).
        photoreceptor: of the photoreceptor's amplifier (PrBp).
        follower: of the source follower behind the photoreceptor (PrSFBp).
        refractory: of the reset (RefrBp).

    Raises:
        SensorConfigError: one is no `Bias`, or ON is not above the differencing amplifier, or OFF
            not below it: the pixel would fire without end.
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
                    f"the bias {each.name} is {bias!r}; allowed is a Bias; "
                    "give one, such as Bias(5, 255)"
                )
        theta = Range(0.01, 10.0, remedy="Set OnBn well above DiffBn, and OffBn well below it.")
        for name in ("theta_on", "theta_off"):
            theta.check(name, getattr(self, name), SensorConfigError)

    @classmethod
    def preset(cls, name: str) -> Self:
        """The maker's defaults for a sensor.

        Args:
            name: `davis346` or `davis240`, which differ in OffBn alone (libcaer).

        Raises:
            SensorConfigError: another name.
        """
        known = {"davis346": cls(), "davis240": cls(off=Bias(4, 0))}
        if name not in known:
            raise SensorConfigError(
                f"the biases are those of {name!r}; allowed is one of {', '.join(known)}; give "
                "single biases instead, such as Biases(on=Bias(5, 255))"
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
    """A sensor whose thresholds, bandwidths and refractory period come from bias currents.

    All of them do, whichever bias was named: the others are the maker's defaults, whose thresholds
    and follower are not those of `SensorConfig`.

    Args:
        config: the sensor otherwise.
        biases: its bias currents.

    Returns:
        The configuration in plain numbers; the refractory period is rounded to 1 µs.

    Raises:
        SensorConfigError: the sensor or the biases are none, or the biases lead out of the range
            of a parameter.
    """
    check_config(config)
    if not isinstance(biases, Biases):
        raise SensorConfigError(
            f"the biases are {biases!r}; allowed is a Biases; make one, such as "
            "Biases(on=Bias(5, 255)), or Biases() for the maker's defaults"
        )
    return replace(
        config,
        theta_on=biases.theta_on,
        theta_off=biases.theta_off,
        bandwidth_limit_hz=biases.bandwidth_limit_hz,
        follower_hz=biases.follower_hz,
        refractory_us=round(biases.refractory_us),
    )
