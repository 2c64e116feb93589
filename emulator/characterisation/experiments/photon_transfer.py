"""The photon transfer curve of the APS frames: variance against mean, after EMVA Standard 1288.

The sensor takes pairs of frames of an evenly lit card at a fixed exposure. Half the variance of
their difference is temporal noise. Where this is photon shot noise it is proportional to the mean,
and the slope is the gain K in levels per electron.

Two things differ from the standard. The read noise is the value of the line at the dark level
instead of the noise of dark frames, because the converter clips negative values to 0 and so hides
their noise. And the quantisation noise, 1/12 of a level squared, is subtracted from all variances.

Fixed-pattern noise is the standard deviation over pixels of the mean of many frames at half
saturation, less the remaining temporal noise, as a share of the mean.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from emulator.characterisation import sources
from emulator.characterisation.bench import chip_luminance, record, uniform_frame
from emulator.characterisation.section import Plot, Quantity, Section, Style, series
from emulator.config import SensorConfig

SIDE_PX = 160
"""Side of the frames: a pair of them gives the variance to within 0.9 %."""
_LEVELS = 20
"""Evenly spaced illuminances; the standard asks for 50, but the line needs only a few."""
_BRIGHTEST = 1.25
"""Highest illuminance of the sweep, over the one that saturates."""
_PERIOD_US = 1_000_000
"""Time from frame to frame, unless exposure and readout take longer [µs]."""
_LONGEST_PERIOD_US = 10_000_000
"""Longest frame period that a configuration allows [µs]."""
_FITTED = (0.02, 0.7)
"""Shares of saturation between which the line is fitted: above clipping, to the standard's 70 %."""
_FPN_FRAMES = 24
"""Frames averaged for the fixed pattern. The remaining temporal noise is a ninth of the variance of
the default pattern, and is subtracted."""
_QUANTISATION = 1.0 / 12.0
"""Variance that rounding adds [DN²]."""
_SEARCH_LUX = np.geomspace(0.01, 1e5, 36)
"""Illuminances tried, five per decade, until a frame reaches a third of saturation [lux]."""

Floats = npt.NDArray[np.float64]
Stack = npt.NDArray[np.uint16]


@dataclass(frozen=True, eq=False)
class PhotonTransfer:
    """A photon transfer curve and the quantities derived from it.

    Attributes:
        mean_dn: (n,) mean levels [DN].
        variance_dn2: (n,) temporal variances without quantisation noise [DN²].
        electrons_per_dn: 1/K [e⁻/DN]; None if the frames have no noise to measure it with.
        read_noise_e: rms noise in the dark [e⁻]; None if the frames have no noise.
        full_well_e: electrons at which a pixel saturates [e⁻]; None if the frames have no noise.
        saturation_dn: level of a saturated pixel [DN].
        fpn_percent: fixed-pattern noise at half saturation, as a share of the mean [%].
    """

    mean_dn: Floats
    variance_dn2: Floats
    electrons_per_dn: float | None
    read_noise_e: float | None
    full_well_e: float | None
    saturation_dn: float
    fpn_percent: float

    @property
    def dynamic_range_db(self) -> float | None:
        """20·log10 of full well over read noise [dB]; None if the frames have no noise."""
        if self.full_well_e is None or not self.read_noise_e:
            return None
        return 20.0 * math.log10(self.full_well_e / self.read_noise_e)


def measure_photon_transfer(config: SensorConfig, *, seed: int) -> PhotonTransfer:
    """Measure the photon transfer of the frames at the exposure `config.aps.exposure_us`."""
    saturation_dn = float(
        record_frames(config, chip_lux=_SEARCH_LUX[-1], number=2, seed=seed).mean()
    )
    full_lux = _saturating_lux(config, saturation_dn, seed)
    levels_lux = np.linspace(0.0, _BRIGHTEST, _LEVELS + 1)[1:] * full_lux
    points = [
        _mean_and_variance(record_frames(config, chip_lux=x, number=2, seed=seed))
        for x in levels_lux
    ]
    mean, variance = (np.array(column) for column in zip(*points, strict=True))
    stack = record_frames(config, chip_lux=0.5 * full_lux, number=_FPN_FRAMES, seed=seed)
    fpn = 100.0 * fixed_pattern_dn(stack) / max(float(stack.mean()), 1.0)
    dark_dn = float(record_frames(config, chip_lux=0.0, number=2, seed=seed).mean())
    per_dn, read_e = fit_line(mean, variance, saturation_dn=saturation_dn, dark_dn=dark_dn)
    full_e = None if per_dn is None else per_dn * (saturation_dn - dark_dn)
    return PhotonTransfer(mean, variance, per_dn, read_e, full_e, saturation_dn, fpn)


def record_frames(config: SensorConfig, *, chip_lux: float, number: int, seed: int) -> Stack:
    """Record frames of a uniform scene at a fixed exposure, (number, SIDE_PX, SIDE_PX) [DN]."""
    period_us = max(_PERIOD_US, config.aps.exposure_us + config.aps.readout_us)
    least_us = min(period_us, _LONGEST_PERIOD_US)
    aps = replace(config.aps, auto_exposure=False, period_min_us=least_us)
    sensor = replace(config, width=SIDE_PX, height=SIDE_PX, aps=aps)
    luminance = uniform_frame(sensor, chip_luminance(sensor, chip_lux))
    times = range(0, (number + 1) * period_us, period_us)
    recording = record(sensor, ((t, luminance) for t in times), seed=seed)
    return np.stack([frame.image for frame in recording.aps_frames[:number]])


def fit_line(
    mean_dn: Floats, variance_dn2: Floats, *, saturation_dn: float, dark_dn: float
) -> tuple[float | None, float | None]:
    """Fit electrons per level and read noise [e⁻] to the straight part; None without noise."""
    low, high = (share * saturation_dn for share in _FITTED)
    straight = (mean_dn > low) & (mean_dn < high)
    if np.count_nonzero(straight) < 3:
        return None, None
    slope, start = np.polyfit(mean_dn[straight], variance_dn2[straight], 1)
    if slope <= 1e-4:
        return None, None
    read_dn2 = max(0.0, float(start + slope * dark_dn))
    return float(1.0 / slope), math.sqrt(read_dn2) / float(slope)


def fixed_pattern_dn(stack: Stack) -> float:
    """Return the standard deviation over pixels of the mean frame, less temporal noise [DN]."""
    levels = stack.astype(np.float64)
    temporal = levels.var(axis=0, ddof=1).mean() / len(levels)
    return math.sqrt(max(0.0, float(levels.mean(axis=0).var() - temporal)))


def measure(config: SensorConfig, *, seed: int) -> Section:
    """Return the section on the photon transfer of the frames."""
    found = measure_photon_transfer(config, seed=seed)
    well_ke = None if found.full_well_e is None else 1e-3 * found.full_well_e
    db = found.dynamic_range_db
    return Section(
        "Frames: photon transfer",
        f"Pairs of {SIDE_PX}×{SIDE_PX} frames of a uniform scene at an exposure of "
        f"{config.aps.exposure_us / 1000:g} ms, after EMVA Standard 1288. The read noise is the "
        "value of the line at the dark level, since dark frames are clipped at 0. Fixed-pattern "
        f"noise is that of the mean of {_FPN_FRAMES} frames at half saturation, as a share of "
        "their mean.",
        [
            Quantity("conversion", "e⁻/DN", found.electrons_per_dn, sources.APS_ELECTRONS_PER_DN),
            Quantity("read noise", "e⁻", found.read_noise_e, sources.APS_READ_NOISE_E),
            Quantity("full well", "ke⁻", well_ke, sources.APS_FULL_WELL_KE),
            Quantity("fixed-pattern noise", "%", found.fpn_percent, sources.APS_FPN_PERCENT),
            Quantity("dynamic range of a frame", "dB", db, sources.APS_DYNAMIC_RANGE_DB),
            Quantity("dynamic range of a frame", "dB", db, sources.APS_DYNAMIC_RANGE_DAVIS240_DB),
        ],
        [_plot(found)],
    )


def _saturating_lux(config: SensorConfig, saturation_dn: float, seed: int) -> float:
    """Return the illuminance on the chip that just saturates the frames [lux].

    It is extrapolated in proportion from the first frame that reaches 30 % of saturation.
    """
    for lux in _SEARCH_LUX:
        mean_dn = float(record_frames(config, chip_lux=lux, number=1, seed=seed).mean())
        if mean_dn >= 0.3 * saturation_dn:
            break
    return float(lux * saturation_dn / mean_dn)


def _mean_and_variance(pair: Stack) -> tuple[float, float]:
    """Return the mean of a pair of frames, and half the variance of their difference [DN, DN²]."""
    first, second = pair.astype(np.float64)
    variance = 0.5 * float((first - second).var()) - _QUANTISATION
    return 0.5 * float(first.mean() + second.mean()), max(0.0, variance)


def _plot(found: PhotonTransfer) -> Plot:
    lines = [series("measured", found.mean_dn, found.variance_dn2, Style.POINTS, 0)]
    if found.electrons_per_dn is not None and found.read_noise_e is not None:
        x = np.linspace(0.0, found.saturation_dn, 50)
        read = (found.read_noise_e / found.electrons_per_dn) ** 2
        lines.append(series("fitted line", x, read + x / found.electrons_per_dn, Style.LINE, 0))
    return Plot(
        "Photon transfer curve",
        "mean level [DN]",
        "temporal variance [DN²]",
        lines,
    )
