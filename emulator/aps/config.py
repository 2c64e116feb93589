"""The parameters of the APS of a DAVIS346, each with its source, or marked as assumed.

Sources: Brandli 2014 = Brandli et al., IEEE JSSC 49(10), 2014 (DAVIS240, the same 18.5 µm pixel);
the paper = the one that this bench reproduces (its DAVIS346: up to 40 frames/s, 55 dB).
For the other values of the DAVIS346 we know no document to cite. They are marked as assumed, with
the values that users report.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from emulator.errors import SensorConfigError
from flybench.checks import Range, check_ranges

SHUTTERS = ("global", "rolling")

_RANGES = {
    "electrons_per_lux_s": Range(
        1.0, 1e9, remedy="Give the electrons that one lux collects per second."
    ),
    "full_well_e": Range(100.0, 1e7, remedy="Give the electrons at which a pixel saturates."),
    "saturation_dn": Range(1, 1023, remedy="Give a level of the 10-bit converter, such as 680."),
    "read_noise_e": Range(0.0, 1e5, remedy="Give electrons rms, such as 66."),
    "exposure_us": Range(1, 10_000_000, remedy="Give whole microseconds, such as 7200."),
    "exposure_min_us": Range(1, 10_000_000, remedy="Give whole microseconds, such as 10."),
    "target_dn": Range(
        1.0, 1023.0, remedy="Give the target mean level of auto-exposure, such as 200."
    ),
    "period_min_us": Range(1, 10_000_000, remedy="Give whole microseconds; 25000 is 40 frames/s."),
    "fixed_pattern": Range(
        0.0, 0.5, remedy="Give the standard deviation of the gain over pixels, such as 0.005."
    ),
    "readout_us": Range(
        0, 10_000_000, remedy="Give the time from the end of an exposure to the next start."
    ),
}


@dataclass(frozen=True, kw_only=True)
class ApsConfig:
    """An active pixel sensor with 10 bits and automatic exposure.

    Attributes:
        electrons_per_lux_s: photoelectrons per lux on the chip and second. 1.1e16 photons/m² per
            lux·s of daylight (assumed) × 18.5² µm² × fill factor 22 % (Brandli 2014) × quantum
            efficiency 24 % (assumed).
        full_well_e: electrons at saturation (assumed: users report up to 37 ke⁻).
        saturation_dn: level at saturation (assumed: users report 680 DN of the 10 bits), which
            gives 54 e⁻/DN.
        read_noise_e: rms noise of a dark pixel [e⁻]: full well over the 55 dB of the paper.
        fixed_pattern: standard deviation of the gain over the pixels (Brandli 2014: 0.5 %);
            differences of the offsets are taken to be removed by double sampling (assumed).
        noise: True for photon shot noise, read noise and fixed-pattern noise (the real sensor has
            all three).
        shutter: "global", all rows are exposed at once, or "rolling", one row after another within
            the time of a readout (the chip has both; global is the maker's default).
        auto_exposure: True if the exposure follows the light (assumed, since the paper saw fewer
            frames at night); if False, it stays at `exposure_us`.
        exposure_us: exposure without auto-exposure [µs] (assumed: users report 7.2 ms as the
            default).
        exposure_min_us: shortest automatic exposure [µs] (assumed).
        exposure_max_us: longest automatic exposure [µs] (assumed: 4.9 frames per second at night,
            where the paper saw fewer than 10).
        target_dn: target mean level of auto-exposure [DN] (assumed: 30 % of saturation).
        period_min_us: shortest time between the starts of two exposures [µs] (the paper: 40
            frames/s).
        readout_us: time to read a frame out [µs] (assumed): from the end of a global exposure to
            the next start, or from the first row of a rolling exposure to the last.

    Raises:
        SensorConfigError: a value is outside its range.
    """

    electrons_per_lux_s: float = 2.0e5
    full_well_e: float = 37_000.0
    saturation_dn: int = 680
    read_noise_e: float = 66.0
    fixed_pattern: float = 0.005
    noise: bool = True
    shutter: Literal["global", "rolling"] = "global"
    auto_exposure: bool = True
    exposure_us: int = 7_200
    exposure_min_us: int = 10
    exposure_max_us: int = 200_000
    target_dn: float = 200.0
    period_min_us: int = 25_000
    readout_us: int = 4_000

    def __post_init__(self) -> None:
        check_ranges(self, _RANGES, SensorConfigError)
        for name in ("noise", "auto_exposure"):
            if not isinstance(getattr(self, name), bool):
                raise SensorConfigError(
                    f"{name} is {getattr(self, name)!r}. Allowed is True or False. "
                    "Choose one of them."
                )
        if self.shutter not in SHUTTERS:
            raise SensorConfigError(
                f"shutter is {self.shutter!r}. Allowed is one of {', '.join(SHUTTERS)}. Choose "
                "global to expose all rows at once, rolling to expose one after another."
            )
        longest = Range(
            self.exposure_min_us, 10_000_000, remedy="Raise it to exposure_min_us or more."
        )
        reachable = Range(1.0, 0.95 * self.saturation_dn, remedy="Lower it below saturation_dn.")
        ranges = {"exposure_max_us": longest, "target_dn": reachable}
        check_ranges(self, ranges, SensorConfigError)

    @property
    def electrons_per_dn(self) -> float:
        """Conversion factor [e⁻/DN]."""
        return self.full_well_e / self.saturation_dn
