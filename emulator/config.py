"""The parameters of an event sensor, each with its source, or marked as assumed.

Sources: Lichtsteiner 2008 = Lichtsteiner, Posch, Delbruck, IEEE JSSC 43(2), 2008 (DVS128);
Brandli 2014 = Brandli et al., IEEE JSSC 49(10), 2014 (DAVIS240); Nozaki 2017 = Nozaki, Delbruck,
IEEE TED 64(8), 2017 (leak); Joubert 2021 = Joubert et al., Front. Neurosci. 15, 2021 (background
activity recorded from 50×50 pixels, whose counts and intervals are published); Taverni 2018 =
Taverni et al., IEEE TCAS-II 65(5), 2018 (DAVIS346); Graça 2021 = Graça, Delbruck, IISW 2021 (noise
of the photoreceptor); cradle and lab = two clips of a DAVIS346, see
docs/explanation/real-recordings.md; v2e = Hu, Liu, Delbruck, CVPRW 2021.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Self

from emulator.aps.config import ApsConfig
from emulator.errors import SensorConfigError
from emulator.readout.config import UNLIMITED, ReadoutConfig
from flybench.checks import Range, check_ranges

_WARM_LEAK_HZ_MAX = 10_000.0
"""Highest leak of a warm chip that is accepted (assumed: 100 000 times the published one)."""

REFERENCE_C = 25.0
"""Temperature of the chip for which dark current and leak are given [°C]."""

_RANGES = {
    "width": Range(1, 32767, remedy="Give whole pixels; events carry 16-bit coordinates."),
    "height": Range(1, 32767, remedy="Give whole pixels; events carry 16-bit coordinates."),
    "pixel_pitch_um": Range(0.5, 1000.0, remedy="Give micrometres, such as 18.5."),
    "focal_length_mm": Range(0.1, 10_000.0, remedy="Give millimetres, such as 6."),
    "f_number": Range(0.5, 64.0, remedy="Give the lens aperture as focal length over diameter."),
    "transmission": Range(0.01, 1.0, remedy="Give the fraction of the light that the lens passes."),
    "dark_lux": Range(
        1e-6, 10.0, remedy="Give a positive value: it keeps the logarithm finite in the dark."
    ),
    "theta_on": Range(0.01, 10.0, remedy="Give a change of ln(illuminance), such as 0.28."),
    "theta_off": Range(
        0.01, 10.0, remedy="Give a change of ln(illuminance) as a positive number, such as 0.35."
    ),
    "theta_mismatch": Range(
        0.0, 1.0, remedy="Give a standard deviation in ln(illuminance), such as 0.024."
    ),
    "bandwidth_hz_per_lux": Range(
        1e-3, 1e15, remedy="Give the cutoff frequency at one lux on the chip."
    ),
    "bandwidth_limit_hz": Range(1e-3, 1e9, remedy="Use 1e9 for no limit."),
    "follower_hz": Range(0.0, 1e9, remedy="Use 0 to leave the follower out."),
    "refractory_us": Range(0, 1_000_000, remedy="Give whole microseconds, such as 270."),
    "leak_hz": Range(0.0, 1000.0, remedy="Use 0 to switch the leak in the dark off."),
    "leak_hz_per_lux": Range(0.0, 1.0, remedy="Use 0 to switch the leak caused by light off."),
    "leak_spread": Range(0.0, 3.0, remedy="Use 0 for the same leak in all pixels."),
    "leak_tail_fraction": Range(0.0, 1.0, remedy="Use 0 for no pixels with a high leak."),
    "leak_tail_spread": Range(0.0, 3.0, remedy="Give a standard deviation of ln(leak)."),
    "noise_sigma": Range(
        0.0, 1.0, remedy="Use 0 to switch the noise of the photoreceptor off; 0.07 is usual."
    ),
    "dark_current_spread": Range(0.0, 3.0, remedy="Use 0 for the same dark current in all pixels."),
    "temperature_c": Range(
        -60.0, 150.0, remedy="Give the temperature of the chip in °C, such as 25."
    ),
    "dark_doubling_k": Range(
        1.0, 100.0, remedy="Give the rise that doubles the dark current, such as 7."
    ),
    "leak_doubling_k": Range(
        1.0, 100.0, remedy="Give the rise that doubles the junction leak, such as 7."
    ),
    "dead_fraction": Range(0.0, 1.0, remedy="Use 0 for no dead pixels."),
    "crazy_fraction": Range(0.0, 1.0, remedy="Use 0 for no crazy pixels."),
    "crazy_hz_min": Range(0.0, 100_000.0, remedy="Give the rate of the slowest crazy pixel."),
    "crazy_hz_max": Range(0.0, 100_000.0, remedy="Give the rate of the fastest crazy pixel."),
    "hot_fraction": Range(0.0, 1.0, remedy="Use 0 for no hot pixels."),
    "hot_hz_min": Range(0.0, 10_000.0, remedy="Give the rate of the slowest hot pixel."),
    "hot_hz_max": Range(0.0, 10_000.0, remedy="Give the rate of the fastest hot pixel."),
}


@dataclass(frozen=True, kw_only=True)
class SensorConfig:
    """An event sensor behind a lens; the defaults are a DAVIS346 with all its noise.

    Attributes:
        width: columns [px] (DAVIS346).
        height: rows [px] (DAVIS346).
        pixel_pitch_um: distance between the centres of neighbouring pixels [µm] (Taverni 2018).
        focal_length_mm: focal length of the lens [mm] (assumed: the lens of this bench). With the
            pixel pitch it sets the field of view.
        f_number: lens aperture, focal length over diameter (assumed: a fast lens, for the night).
        transmission: fraction of the incident light that passes the lens (assumed: coated glass).
        dark_lux: median dark current of the photodiodes, as the illuminance on the chip that gives
            the same current [lux]. Its order follows from Lichtsteiner 2008: usable down to 0.1 lux
            on the scene through f/1.2, which is 0.1/(4·1.2²) = 0.017 lux on the chip for a white
            scene.
        theta_on: rise of ln(current) that causes an ON event (assumed: the maker's bias codes give
            0.283, see `emulator.biases`; events of known edges would give about 0.4).
        theta_off: fall of ln(current) that causes an OFF event: 1.25 times `theta_on`, the ratio of
            ON to OFF events on the dark floor of cradle. A detector that resets to what it sees
            conserves θ_on·rate_on − θ_off·rate_off = leak; Joubert 2021 gives 1.33.
        theta_mismatch: standard deviation of either threshold over the pixels: 8.5 % of the ON
            threshold (Joubert 2021: scatter of ln(ON/OFF) over the pixels). A threshold drawn below
            0.01 is set to 0.01 (assumed): with a mismatch as large as the threshold, such as 1, the
            spread is no longer normal, and many pixels are at 0.01.
        bandwidth_hz_per_lux: cutoff of the photoreceptor per lux on the chip [Hz/lux]. Assumed,
            from f = I/(2π·C·U) with 0.09 pA/lux, C = 4.3 fF, U = 33 mV. It gives the 30 Hz of
            v2e's night preset at 0.3 lux, and the 3 kHz of Lichtsteiner 2008 at 1 klux if that
            illuminates an 18 % grey scene seen through f/1.2 (31 lux on the chip). If Joubert 2021
            gives illuminances on the scene, it is 17 times as high; see
            `emulator.characterisation.experiments.background`.
        bandwidth_limit_hz: cutoff that the biases allow in bright light [Hz] (Lichtsteiner 2008).
        follower_hz: cutoff of the source follower behind the photoreceptor, which makes the pixel
            second order [Hz]; 0 leaves it out (as v2e does). 286 Hz is what the maker's bias codes
            give (`emulator.biases`); without it the noise at 1 to 10 lux would be ten times what
            any camera shows.
        refractory_us: time after an event during which a pixel is held in reset [µs]. Lab: of
            97 445 intervals of a pixel, one is shorter than 250 µs, 272 are from 250 to 300 µs.
        leak_hz: rate of ON events of the junction leak in the dark, of the median pixel [Hz].
            Joubert 2021: 0.055 Hz at 161 lux. The bright wall of cradle shows less than 0.005 Hz.
        leak_hz_per_lux: rate of ON events that parasitic photocurrent adds per lux on the chip, in
            the median pixel [Hz/lux] (Joubert 2021: 0.125 Hz at 3 klux; Nozaki 2017 explains it).
        leak_spread: standard deviation of ln(leak) over nine tenths of the pixels (Joubert 2021:
            0.45 at 161 lux, 0.3 at 3 klux, from the histograms of intervals).
        leak_tail_fraction: fraction of pixels with a higher leak, see `emulator.noise.leak`
            (Joubert 2021). The noisiest of them are the hot pixels.
        leak_tail_spread: standard deviation of ln(leak) over those pixels (Joubert 2021).
        noise_sigma: standard deviation σ0 of the noise at the photoreceptor's output while its
            bandwidth is proportional to the light [ln units]; 0 is no noise. It is a quarter of
            `theta_on` for the rate on the dark floor of cradle; q/(C·U) gives 0.034 to 0.041, Graça
            2021 0.043 to 0.073. See `emulator.noise.photoreceptor_noise`.
        dark_current_spread: standard deviation of ln(dark current) over the pixels (Joubert 2021:
            spread of ln(rate) at 0.1 lux. Assumed: log-normal, and a spread of the dark current
            rather than of the noise).
        hot_fraction: fraction of pixels that fire ON at a high rate, whatever the light (assumed:
            none, since the tail of the leak contains them).
        hot_hz_min: rate of the slowest of them [Hz] (Joubert 2021: 18 and 45 Hz).
        hot_hz_max: rate of the fastest of them [Hz] (Joubert 2021).
        temperature_c: temperature of the chip [°C]. `dark_lux` and `leak_hz` are given at 25 °C
            (assumed) and grow with it (Nozaki 2017: both follow an Arrhenius law).
        dark_doubling_k: rise that doubles the dark current [K] (assumed: 6 to 8 K in silicon).
        leak_doubling_k: rise that doubles the junction leak [K] (assumed: as the dark current).
        dead_fraction: fraction of pixels that never fire (assumed: none, because the maker rejects
            chips with dead pixels).
        crazy_fraction: fraction of pixels that fire ON and OFF at random, whatever the light
            (assumed: none). Their events count as events of hot pixels.
        crazy_hz_min: rate of the slowest crazy pixel [Hz] (assumed).
        crazy_hz_max: rate of the fastest crazy pixel [Hz] (assumed).
        readout: how events leave the chip.
        aps: the frame part of the sensor.

    Raises:
        SensorConfigError: a value is outside its range.
    """

    width: int = 346
    height: int = 260
    pixel_pitch_um: float = 18.5
    focal_length_mm: float = 6.0
    f_number: float = 1.4
    transmission: float = 0.9
    dark_lux: float = 0.01
    theta_on: float = 0.28
    theta_off: float = 0.35
    theta_mismatch: float = 0.024
    bandwidth_hz_per_lux: float = 100.0
    bandwidth_limit_hz: float = 3000.0
    follower_hz: float = 286.0
    refractory_us: int = 270
    leak_hz: float = 0.05
    leak_hz_per_lux: float = 2.6e-5
    leak_spread: float = 0.4
    leak_tail_fraction: float = 0.1
    leak_tail_spread: float = 1.4
    noise_sigma: float = 0.07
    dark_current_spread: float = 0.45
    hot_fraction: float = 0.0
    hot_hz_min: float = 45.0
    hot_hz_max: float = 56.0
    temperature_c: float = 25.0
    dark_doubling_k: float = 7.0
    leak_doubling_k: float = 7.0
    dead_fraction: float = 0.0
    crazy_fraction: float = 0.0
    crazy_hz_min: float = 100.0
    crazy_hz_max: float = 1000.0
    readout: ReadoutConfig = field(default_factory=ReadoutConfig)
    aps: ApsConfig = field(default_factory=ApsConfig)

    def __post_init__(self) -> None:
        check_ranges(self, _RANGES, SensorConfigError)
        for name, kind in (("readout", ReadoutConfig), ("aps", ApsConfig)):
            value = getattr(self, name)
            if not isinstance(value, kind):
                raise SensorConfigError(
                    f"{name} is {value!r}. Allowed is a value of type {kind.__name__}. Leave it "
                    "out for the default."
                )
        self._check_dependent()

    def _check_dependent(self) -> None:
        """Check the values whose range depends on other values."""
        warm_leak_hz = Range(
            0.0,
            _WARM_LEAK_HZ_MAX,
            remedy="Lower leak_hz or temperature_c, or raise leak_doubling_k.",
        )
        warm_leak_hz.check("warm_leak_hz", self.warm_leak_hz, SensorConfigError)
        hot_hz_max = Range(self.hot_hz_min, 10_000.0, remedy="Raise it to hot_hz_min or more.")
        crazy_hz_max = Range(
            self.crazy_hz_min, 100_000.0, remedy="It may not be below crazy_hz_min."
        )
        check_ranges(
            self, {"hot_hz_max": hot_hz_max, "crazy_hz_max": crazy_hz_max}, SensorConfigError
        )

    @property
    def focal_length_px(self) -> float:
        """Focal length of the lens in pixels."""
        return self.focal_length_mm / self.pixel_pitch_um * 1e3

    @property
    def warm_dark_lux(self) -> float:
        """Dark current at the temperature of the chip [lux]."""
        doublings = (self.temperature_c - REFERENCE_C) / self.dark_doubling_k
        return self.dark_lux * math.exp2(doublings)

    @property
    def warm_leak_hz(self) -> float:
        """Rate of ON events of the junction leak at the temperature of the chip [Hz]."""
        doublings = (self.temperature_c - REFERENCE_C) / self.leak_doubling_k
        return self.leak_hz * math.exp2(doublings)

    @classmethod
    def noise_free(cls, *, width: int = 346, height: int = 260) -> Self:
        """Return a sensor without leak, photoreceptor noise, hot and crazy pixels and APS noise.

        Thresholds and dark current with their mismatch, bandwidth and refractory period are the
        defaults.
        """
        return cls(
            width=width,
            height=height,
            leak_hz=0.0,
            leak_hz_per_lux=0.0,
            noise_sigma=0.0,
            hot_fraction=0.0,
            crazy_fraction=0.0,
            aps=ApsConfig(noise=False),
        )

    @classmethod
    def ideal(cls, *, width: int = 346, height: int = 260) -> Self:
        """Return an ideal sensor: no noise, no mismatch, unlimited bandwidth, rate and readout."""
        return replace(
            cls.noise_free(width=width, height=height),
            theta_mismatch=0.0,
            dark_current_spread=0.0,
            bandwidth_hz_per_lux=1e15,
            bandwidth_limit_hz=1e9,
            follower_hz=0.0,
            refractory_us=0,
            readout=UNLIMITED,
        )
