"""The parameters of the fly, each with its unit and its source."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any

from detector.errors import DetectorConfigError
from detector.fly.model_variants import (
    Attention,
    Averaging,
    LocalMotion,
    Normalisation,
    Offsets,
    PairLocation,
    ReceptiveFields,
    RegionActivity,
    SurfaceEvents,
)
from detector.windowed import check_whole_hops
from flybench.checks import Range, check_ranges, member


@dataclass(frozen=True, slots=True, kw_only=True)
class FlyConfig:
    """Parameters of `FlyDetector`: Table I of the paper, and what the paper leaves open.

    `detector.fly.model_variants` compares the choices that are enumerations.

    Attributes:
        tau_us: time constant τ of the time surface [µs]. Table I.
        window_us: Δt, window of the time surface and of its average [µs]. Table I.
        hop_us: step between estimates [µs]; the window and the delays are multiples of it. Assumed.
        delay_us: lag of the delayed signal [µs]. The default is one Δt, which gives the previous
            window (assumed).
        further_delays_us: further lags [µs]. With any, the delayed signal is the mean over all
            lags: a delay line with several taps. The paper has none.
        cell_px: side of a cell [px]. Section II-B.
        neighbourhood_px: half side of the neighbourhood z of equation 3, over which a surface is
            summed [px]. 0 is the pixel alone, so that an isolated event scores 0 (assumed).
        time_surface: whether an event counts in its own surface. By default it does not, as in
            equation 3.
        event_gain: share of what is missing to 1 that an event adds to its pixel's surface, if the
            surface saturates. Other surfaces have none.
        mains_notch: True to leave out of saturating surfaces the bursts of events that follow the
            one before by a multiple of 10 or 8.33 ms, as under lamps on mains of 50 or 60 Hz. Only
            in a pixel that has fired in the last window; other surfaces have none.
        inhibition: level that lateral inhibition subtracts from saturating surfaces, above the mean
            of the field [standard deviations]. Other surfaces have none, as in the paper.
        averaging: divisor of a cell's sum. By default the number of events, as in equation 5.
        spacing_cells: sd, the shortest correlation distance [cells]. Table I.
        spacings: n_c, the number of correlation distances. Table I.
        offsets: series of the correlation distances. Multiples of sd (assumed).
        receptive_fields: size of the two points of a correlation. One cell, as in equation 9.
        pair_location: cell that a correlation belongs to. The midpoint of the pair (assumed).
        attention: how the view centre is placed. By steering, section II-D.
        local_motion: what ℳ of equation 13 is relative to. By default the total in the search
            square (assumed).
        g_m: gain of the motion response in steering [cells]. Table I.
        g_p: gain of the position response in steering [cells]. Table I.
        alpha: weight of the new response in the steering low-pass: Δt / (Δt + τ_s) with τ_s = Δt.
            Assumed.
        exponent_cap: largest exponent of the position response. 4 is reached at half the side of
            the grid; beyond it, every shift ends on its target anyway (assumed).
        roi_radius_px: R, half side of the search square [px]. Table I, read as sensor pixels.
        roi_activity: activity on which the region grows. Present and delayed surfaces (assumed).
        roi_smoothing_cells: half side of the box that smooths this activity [cells]. sd: cells
            closer together than a correlation distance belong to one object (assumed).
        roi_share: least activity of a cell in the region, relative to the largest in the search
            square. Assumed.
        saliency_radius_cells: half side of the box that smooths the saliency [cells]. 8 gives a box
            of 51 px, half the side of the search square, so that what fills the square wins over
            what is merely bright. On synthetic cars this gave a seventh of the wrong estimates that
            a value of 2 gave (assumed).
        saliency_floor: least height of the saliency maximum above its mean that draws attention.
            0.1: synthetic noise of 0.1 to 20 Hz per pixel with hot pixels reaches 0.10, synthetic
            cars at 350 px/s reach 0.3 to 2 (assumed).
        crowd_share: least height of the saliency maximum above its mean that draws attention, as a
            share of the activity beyond that of noise. It is for flickering light, which makes the
            whole field active; 0: no such floor, as in the paper.
        integration_us: time constant of the low-pass of the tangential cells [µs], which keeps the
            direction of a target while little but an oblique part of it is in view, or the camera
            shakes. 0: none, as in the paper.
        normalisation: how a response is mapped into (−1, 1). Sigmoid over cells (assumed).
        response_scale: response per grid cell that scales the sigmoid. One value serves day and
            night: with 3, simulated crossings at 0.9 rad/s (day, night) and 3.0 rad/s, slower and
            faster than any that detectors are evaluated on, have medians of 0.22, 0.36, 0.91 and
            0.95 with samples up to 4 px apart (assumed).
        snr_floor: least signal-to-noise ratio of a response that counts as motion; see
            `detector.fly.tangential.signal_to_noise`. 3 standard deviations: in noise the ratio is
            about a normal variable, which exceeds them once in 370 times (assumed).
        share_floor: least response, relative to the sum of its two directions, that counts as
            motion; see `detector.fly.tangential.shares_of_total`. 0.01 suppresses much of the
            response to flickering light on a still scene, and no right response to synthetic
            targets of 30 to 240 px. 0.03 would cost 6 percentage points on those of 240 px
            (assumed).
        quiet_limit_us: time after the last event at which estimates stop [µs]. Assumed: 60 s, far
            longer than any crossing, and at most 6000 estimates.

    Raises:
        DetectorConfigError: a value has the wrong type or is out of range. NumPy's whole numbers
            are accepted, and strings for enumerations, as read back from JSON.
    """

    tau_us: int = 30_000
    window_us: int = 50_000
    hop_us: int = 10_000
    delay_us: int = 50_000
    further_delays_us: tuple[int, ...] = ()
    cell_px: int = 3
    neighbourhood_px: int = 0
    time_surface: SurfaceEvents = SurfaceEvents.EARLIER
    event_gain: float = 1.0
    mains_notch: bool = False
    inhibition: float = 0.0
    averaging: Averaging = Averaging.EVENTS
    spacing_cells: int = 4
    spacings: int = 4
    offsets: Offsets = Offsets.EVEN
    receptive_fields: ReceptiveFields = ReceptiveFields.CELL
    pair_location: PairLocation = PairLocation.MIDPOINT
    attention: Attention = Attention.STEERED
    local_motion: LocalMotion = LocalMotion.SHARE
    g_m: float = 5.0
    g_p: float = 30.0
    alpha: float = 0.5
    exponent_cap: float = 4.0
    roi_radius_px: int = 50
    roi_activity: RegionActivity = RegionActivity.BOTH
    roi_smoothing_cells: int = 4
    roi_share: float = 0.1
    saliency_radius_cells: int = 8
    saliency_floor: float = 0.1
    crowd_share: float = 0.0
    integration_us: int = 0
    normalisation: Normalisation = Normalisation.CELLS
    response_scale: float = 3.0
    snr_floor: float = 3.0
    share_floor: float = 0.01
    quiet_limit_us: int = 60_000_000

    @property
    def window_hops(self) -> int:
        """Number of hops in a window."""
        return self.window_us // self.hop_us

    @property
    def delays_hops(self) -> tuple[int, ...]:
        """Lag of each tap of the delayed signal [hops]."""
        return tuple(d // self.hop_us for d in (self.delay_us, *self.further_delays_us))

    @property
    def memory_us(self) -> int:
        """Time that an estimate needs to see all that it compares: window and longest delay [µs].

        The low-pass of the tangential cells, which only averages earlier responses, does not count:
        it starts with the first of them, and shares of its sums need no time to rise.
        """
        return (self.window_hops + max(self.delays_hops)) * self.hop_us

    @property
    def offsets_cells(self) -> tuple[int, ...]:
        """Correlation distances [cells]."""
        if self.offsets is Offsets.DOUBLING:
            return tuple(self.spacing_cells << n for n in range(self.spacings))
        return tuple(self.spacing_cells * n for n in range(1, self.spacings + 1))

    @property
    def roi_reach_cells(self) -> float:
        """R, half side of the search square [cells]."""
        return self.roi_radius_px / self.cell_px

    @classmethod
    def preset(cls, name: str) -> FlyConfig:
        """Return the parameters of a preset: "paper", or "wide" for more speeds; see `PRESETS`.

        Raises:
            DetectorConfigError: there is no preset of this name.
        """
        if not isinstance(name, str) or name not in PRESETS:
            raise DetectorConfigError(
                f"The preset is {name!r}. Allowed is one of {', '.join(map(repr, PRESETS))}."
            )
        return PRESETS[name]

    def __post_init__(self) -> None:
        """Check every value and convert it to its type."""
        check_ranges(self, _RANGES, DetectorConfigError)
        object.__setattr__(self, "further_delays_us", _delays(self.further_delays_us))
        for field in fields(self):
            if isinstance(field.default, StrEnum):
                kind, value = type(field.default), getattr(self, field.name)
                choice = member(kind, field.name, value, DetectorConfigError)
                object.__setattr__(self, field.name, choice)
        self._check_surface()
        self._check_distances()
        self._check_times()

    def _check_surface(self) -> None:
        is_saturating = self.time_surface is SurfaceEvents.SATURATING
        if is_saturating and (self.averaging is not Averaging.AREA or self.neighbourhood_px):
            raise DetectorConfigError(
                f"averaging is {self.averaging.value!r} and neighbourhood_px is "
                f"{self.neighbourhood_px}. Allowed with time_surface = 'saturating' is 'area' and "
                "0. Set these."
            )
        if not is_saturating and (self.inhibition or self.event_gain != 1.0):
            raise DetectorConfigError(
                f"inhibition is {self.inhibition}, and event_gain is {self.event_gain}. Allowed "
                f"with time_surface = {self.time_surface.value!r} is 0 and 1. Leave them out, or "
                "set time_surface to 'saturating'."
            )

    def _check_distances(self) -> None:
        longest = self.offsets_cells[-1]
        if longest > _LONGEST_CELLS:
            raise DetectorConfigError(
                f"spacings is {self.spacings}: with spacing_cells = {self.spacing_cells} and "
                f"offsets = {self.offsets.value!r} the longest distance is {longest} cells. "
                f"Allowed is {_LONGEST_CELLS} cells or less. Choose fewer spacings."
            )

    def _check_times(self) -> None:
        check_whole_hops(self.hop_us, window_us=self.window_us, delay_us=self.delay_us)
        for delay_us in self.further_delays_us:
            check_whole_hops(self.hop_us, further_delays_us=delay_us)
        hops = self.window_hops + max(self.delays_hops)
        if hops > _MOST_HOPS:
            raise DetectorConfigError(
                f"hop_us is {self.hop_us} µs, which cuts window_us and the longest delay into "
                f"{hops} hops. Allowed is {_MOST_HOPS}, since each is kept in memory. Choose a "
                "longer hop."
            )
        if self.window_us > _LONGEST_TAUS * self.tau_us:
            raise DetectorConfigError(
                f"window_us is {self.window_us} µs. Allowed is {_LONGEST_TAUS} tau_us = "
                f"{_LONGEST_TAUS * self.tau_us} µs or less, since older events have no weight. "
                "Choose a shorter window."
            )
        if self.quiet_limit_us < self.memory_us:
            raise DetectorConfigError(
                f"quiet_limit_us is {self.quiet_limit_us} µs. Allowed is window_us + the longest "
                f"delay = {self.memory_us} µs or more. Choose a longer limit."
            )


def _delays(value: Any) -> tuple[int, ...]:
    name = "further_delays_us"
    if not isinstance(value, tuple | list) or len(value) > _MOST_FURTHER_DELAYS:
        raise DetectorConfigError(
            f"{name} is {value!r}. Allowed is a tuple of up to {_MOST_FURTHER_DELAYS} lags in µs. "
            "The default is ()."
        )
    return tuple(int(_DELAY_US.check(name, lag, DetectorConfigError)) for lag in value)


_MOST_HOPS = 1000
"""Largest number of hops in memory: 323 MB with the default grid (assumed)."""
_LONGEST_CELLS = 100_000
"""Longest correlation distance [cells]: what `Offsets.EVEN` can reach, beyond any sensor."""
_LONGEST_TAUS = 100
"""Longest window [τ]: e^−100 is negligible."""
_MOST_FURTHER_DELAYS = 16
"""Largest number of taps besides the first (assumed)."""

_DELAY_US = Range(1, 10_000_000)
_RANGES: dict[str, Range] = {
    "tau_us": Range(1, 10_000_000),
    "window_us": Range(1, 10_000_000),
    "hop_us": Range(1, 10_000_000),
    "delay_us": _DELAY_US,
    "cell_px": Range(1, 64),
    "neighbourhood_px": Range(0, 10),
    "event_gain": Range(0.01, 1.0),
    "inhibition": Range(0.0, 10.0),
    "spacing_cells": Range(1, 1000),
    "spacings": Range(1, 100),
    "g_m": Range(0.0, 1000.0),
    "g_p": Range(0.0, 1000.0),
    "alpha": Range(0.01, 0.99),
    "exponent_cap": Range(0.01, 100.0),
    "roi_radius_px": Range(1, 10_000),
    "roi_smoothing_cells": Range(0, 50),
    "roi_share": Range(0.001, 1.0),
    "saliency_radius_cells": Range(0, 50),
    "saliency_floor": Range(0.0, 1000.0),
    "crowd_share": Range(0.0, 1.0),
    "integration_us": Range(0, 10_000_000),
    "response_scale": Range(1e-6, 1000.0),
    "snr_floor": Range(0.0, 1000.0),
    "share_floor": Range(0.0, 1.0),
    "quiet_limit_us": Range(1, 3_600_000_000),
}

PRESETS = {
    "paper": FlyConfig(),
    "wide": FlyConfig(
        delay_us=30_000,
        further_delays_us=(100_000, 200_000),
        spacing_cells=1,
        spacings=5,
        offsets=Offsets.DOUBLING,
        saliency_floor=0.03,
    ),
    "robust": FlyConfig(
        hop_us=5_000,
        delay_us=5_000,
        further_delays_us=(20_000, 40_000),
        time_surface=SurfaceEvents.SATURATING,
        averaging=Averaging.AREA,
        event_gain=0.1,
        mains_notch=True,
        inhibition=2.0,
        spacing_cells=1,
        spacings=3,
        offsets=Offsets.DOUBLING,
        receptive_fields=ReceptiveFields.DISTANCE,
        saliency_floor=0.0008,
        crowd_share=0.1,
        integration_us=80_000,
        normalisation=Normalisation.ALL,
        snr_floor=3.5,
        share_floor=0.012,
    ),
}
"""Parameters by name.

paper: Table I, and our choices for what it leaves open.

wide: for image speeds of 60 to 1500 px/s. It differs from the paper preset in three things:

- Distances of 1, 2, 4, 8 and 16 cells instead of 4, 8, 12 and 16. Opponent correlation compares
  how well the delayed image fits the present one when it is shifted forwards and when it is shifted
  backwards. If an object moved by less than the shortest distance, the two shifts lie on opposite
  slopes of the object's own autocorrelation. With a repeated texture (panels, wheels) the
  autocorrelation may rise again there, and the sign flips. The shortest distance possible stays on
  the central peak, whose slope has one sign. The longest distance is that of the paper.
- Three delays of 30, 100 and 200 ms instead of one of 50 ms. At 60 px/s an object moves less than a
  cell in 50 ms, but 12 px in 200 ms. At 1500 px/s it moves 45 px in 30 ms, within the longest
  distance of 48 px; its traces at the longer delays have left the region of interest.
- Attention from a saliency of 0.03 instead of 0.1, because a slow edge without texture reaches no
  more. In noise above about 5 Hz per pixel, attention then wanders while nothing moves, but the
  signal-to-noise floor still gives `NONE`.

robust: for real sensors: one to five events an edge, oblique edges, flickering light. It was found
on drawn bars, boxes, discs and textures, and on three public recordings, which therefore do not
judge it; docs/explanation/operating-range.md gives each difference and its reason. Every value is
assumed.
"""
