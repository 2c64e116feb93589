"""Every parameter of the fly, with its unit and its source."""

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
    RegionActivity,
    TimeSurface,
)
from detector.windowed import check_whole_hops
from flybench.checks import Range, check_ranges, member


@dataclass(frozen=True, slots=True, kw_only=True)
class FlyConfig:
    """Parameters of `FlyDetector`: Table I of the paper, and what the paper leaves open.

    Attributes:
        tau_us: time constant τ of the time surface [µs]. Table I.
        window_us: Δt, window of the time surface and of its average [µs]. Table I.
        hop_us: step between estimates [µs]; Δt and the delay are multiples of it. Assumed.
        delay_us: how far the delayed signal lags [µs]. One Δt: the previous window (assumed).
        further_delays_us: other lags; the delayed signal is then the mean over all of them, a delay
            line with several taps [µs]. None in the paper.
        cell_px: side of a cell [px]. Section II-B.
        neighbourhood_px: half side of the neighbourhood z of equation 3, over which a surface is
            summed [px]. 0, the pixel alone, so that an isolated event scores 0 (assumed).
        time_surface: whether an event counts in its own surface. Not, equation 3.
        averaging: what a cell's sum is divided by. The number of events, equation 5.
        spacing_cells: sd, shortest correlation distance [cells]. Table I.
        spacings: n_c, number of correlation distances. Table I.
        offsets: how the distances follow one another. In steps of sd (assumed).
        pair_location: the cell to which a correlation belongs. The pair's midpoint (assumed).
        attention: how the view centre finds its place. By steering, section II-D.
        local_motion: what ℳ of equation 13 is relative to. The total nearby (assumed).
        g_m: gain of the motion response in steering [cells]. Table I.
        g_p: gain of the position response in steering [cells]. Table I.
        alpha: share of the new response in the steering low-pass; Δt / (Δt + τ_s) with τ_s = Δt.
            Assumed.
        exponent_cap: largest exponent of the position response. 4, reached at half the grid's
            side; from there on every shift ends on its target anyway (assumed).
        roi_radius_px: R, half side of the search square [px]. Table I, read as sensor pixels.
        roi_activity: what the region grows on. Present and delayed surfaces (assumed).
        roi_smoothing_cells: half side of the box that smooths the activity on which the region
            grows [cells]. sd: what lies closer than a correlation distance belongs together
            (assumed).
        roi_share: activity that joins the region, relative to the largest in the square. Assumed.
        saliency_radius_cells: half side of the box that smooths the saliency [cells]. 8 makes a box
            of 51 px, half the search square's side, so that what fills the square wins over what is
            merely bright; drawn cars then gave a seventh of the wrong estimates of 2 (assumed).
        saliency_floor: least height of the saliency's maximum over its mean that draws attention.
            0.1: drawn noise of 0.1 to 20 Hz a pixel with hot pixels reaches 0.10, cars at 350 px/s
            reach 0.3 to 2 (assumed).
        normalisation: what brings a response into (−1, 1). The sigmoid over cells (assumed).
        response_scale: response per grid cell that the sigmoid scales by. One value by day and by
            night: with 3, simulated crossings at 0.9 rad/s (day, night) and 3.0 rad/s, faster and
            slower than any that is judged on, have medians of 0.22, 0.36, 0.91 and 0.95 with
            samples up to 4 px apart (assumed).
        snr_floor: least signal-to-noise ratio of a response that counts as motion; see
            `detector.fly.tangential.signal_to_noise`. 3 standard deviations: noise gives about a
            normal variable, which passes them once in 370 times (assumed).
        share_floor: least share of a response in the sum of its two directions that counts as
            motion; see `detector.fly.tangential.shares_of_total`. 0.01: much of what flickering
            light gives before a still scene stays below; of drawn targets of 30 to 240 px nothing
            that is right does, while 0.03 would cost those of 240 px 6 points (assumed).
        quiet_limit_us: how long after the last event estimates go on [µs]. Assumed: 60 s, far
            beyond any crossing, and 6000 estimates at most.

    Raises:
        DetectorConfigError: a value of another type or outside its range. Whole numbers may be
            NumPy's, and `averaging` a string, as read back from JSON.
    """

    tau_us: int = 30_000
    window_us: int = 50_000
    hop_us: int = 10_000
    delay_us: int = 50_000
    further_delays_us: tuple[int, ...] = ()
    cell_px: int = 3
    neighbourhood_px: int = 0
    time_surface: TimeSurface = TimeSurface.EARLIER
    averaging: Averaging = Averaging.EVENTS
    spacing_cells: int = 4
    spacings: int = 4
    offsets: Offsets = Offsets.EVEN
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
    normalisation: Normalisation = Normalisation.CELLS
    response_scale: float = 3.0
    snr_floor: float = 3.0
    share_floor: float = 0.01
    quiet_limit_us: int = 60_000_000

    @property
    def window_hops(self) -> int:
        """HopBuffer in a window."""
        return self.window_us // self.hop_us

    @property
    def delays_hops(self) -> tuple[int, ...]:
        """HopBuffer by which each tap of the delayed signal lags."""
        return tuple(d // self.hop_us for d in (self.delay_us, *self.further_delays_us))

    @property
    def offsets_cells(self) -> tuple[int, ...]:
        """Correlation distances [cells]."""
        if self.offsets is Offsets.DOUBLING:
            return tuple(self.spacing_cells << n for n in range(self.spacings))
        return tuple(self.spacing_cells * n for n in range(1, self.spacings + 1))

    @property
    def roi_reach_cells(self) -> float:
        """R in cells."""
        return self.roi_radius_px / self.cell_px

    @classmethod
    def preset(cls, name: str) -> FlyConfig:
        """Parameters by name: "paper", or "wide" for more speeds; see `PRESETS`.

        Raises:
            DetectorConfigError: there is none of this name.
        """
        if not isinstance(name, str) or name not in PRESETS:
            raise DetectorConfigError(
                f"the preset is {name!r}; allowed is one of {', '.join(map(repr, PRESETS))}"
            )
        return PRESETS[name]

    def __post_init__(self) -> None:
        """Check every value, and bring it to its type."""
        check_ranges(self, _RANGES, DetectorConfigError)
        object.__setattr__(self, "further_delays_us", _delays(self.further_delays_us))
        for field in fields(self):
            if isinstance(field.default, StrEnum):
                kind, value = type(field.default), getattr(self, field.name)
                choice = member(kind, field.name, value, DetectorConfigError)
                object.__setattr__(self, field.name, choice)
        self._check_distances()
        self._check_times()

    def _check_distances(self) -> None:
        longest = self.offsets_cells[-1]
        if longest > _MOST_CELLS:
            raise DetectorConfigError(
                f"spacings is {self.spacings}, which with spacing_cells = {self.spacing_cells} and "
                f"offsets = {self.offsets.value!r} makes the longest distance {longest} cells; "
                f"allowed is {_MOST_CELLS} or less; lower spacings"
            )

    def _check_times(self) -> None:
        check_whole_hops(self.hop_us, window_us=self.window_us, delay_us=self.delay_us)
        for delay_us in self.further_delays_us:
            check_whole_hops(self.hop_us, further_delays_us=delay_us)
        if self.window_hops + max(self.delays_hops) > _MOST_HOPS:
            raise DetectorConfigError(
                f"hop_us is {self.hop_us} µs, which cuts window_us and the longest delay into "
                f"{self.window_hops + max(self.delays_hops)} hops; allowed are {_MOST_HOPS}, for "
                "each is kept in memory; choose a longer hop"
            )
        if self.window_us > _MOST_TAUS * self.tau_us:
            raise DetectorConfigError(
                f"window_us is {self.window_us} µs; allowed is {_MOST_TAUS} tau_us = "
                f"{_MOST_TAUS * self.tau_us} µs or less, for of older events nothing is left; "
                "choose a shorter window"
            )
        seen_us = self.window_us + max(self.delays_hops) * self.hop_us
        if self.quiet_limit_us < seen_us:
            raise DetectorConfigError(
                f"quiet_limit_us is {self.quiet_limit_us} µs; allowed is window_us + the longest "
                f"delay = {seen_us} µs or more, else it cuts off what is still seen"
            )


def _delays(value: Any) -> tuple[int, ...]:
    name = "further_delays_us"
    if not isinstance(value, tuple | list) or len(value) > _MOST_DELAYS:
        raise DetectorConfigError(
            f"{name} is {value!r}; allowed is a tuple of up to {_MOST_DELAYS} lags in µs; the "
            "default is ()"
        )
    lags = (_LAGS_US.check(name, lag, DetectorConfigError) for lag in value)
    return tuple(int(lag) for lag in lags)


_MOST_HOPS = 1000
"""Most hops kept: 323 MB with the default grid (assumed)."""
_MOST_CELLS = 100_000
"""Longest distance: as far as even steps reach, beyond any sensor."""
_MOST_TAUS = 100
"""Longest window in τ: e^−100 is nothing."""
_MOST_DELAYS = 16
"""Most taps besides the first (assumed)."""

_LAGS_US = Range(1, 10_000_000)
_RANGES: dict[str, Range] = {
    "tau_us": Range(1, 10_000_000),
    "window_us": Range(1, 10_000_000),
    "hop_us": Range(1, 10_000_000),
    "delay_us": _LAGS_US,
    "cell_px": Range(1, 64),
    "neighbourhood_px": Range(0, 10),
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
}
"""Parameters by name.

paper: Table I, and what is settled for what it leaves open.

wide: for image speeds of 60 to 1500 px/s. It departs from the paper preset in three things:

- Distances of 1, 2, 4, 8 and 16 cells in place of 4, 8, 12 and 16. Opponent correlations compare
  how well the delayed image fits the present one when shifted forwards and when shifted backwards.
  What moved by less than the shortest distance is compared on two slopes of its own
  autocorrelation, which may rise again with a repeated texture (panels, wheels): the sign flips.
  The shortest distance possible sees the central peak, whose slope has one sign; the longest is as
  long as the paper's.
- Three delays of 30, 100 and 200 ms in place of 50. At 60 px/s an object moves less than a cell
  in 50 ms, and 12 px in 200; at 1500 px/s it moves 45 px in 30 ms, within the longest distance of
  48; what it leaves at the longer delays has gone from the region of interest.
- Attention from a saliency of 0.03 on in place of 0.1: a slow rim without texture reaches no more.
  In noise of some 5 Hz a pixel and more, attention then wanders while nothing moves; the
  signal-to-noise floor still says none.
"""
