"""Every parameter of the fly, with its unit and its source."""

from __future__ import annotations

from dataclasses import dataclass, fields
from numbers import Integral, Real
from typing import Any

from detector.errors import DetectorConfigError
from detector.histogram import Averaging


@dataclass(frozen=True, slots=True, kw_only=True)
class FlyConfig:
    """Parameters of `FlyDetector`: Table I of the paper, and what the paper leaves open.

    Attributes:
        tau_us: time constant τ of the time surface [µs]. Table I.
        window_us: Δt, window of the time surface and of its average [µs]. Table I.
        hop_us: step between estimates [µs]; Δt and the delay are multiples of it. Assumed.
        delay_us: how far the delayed signal lags [µs]. One Δt: the previous window (assumed).
        cell_px: side of a cell [px]. Section II-B.
        neighbourhood_px: half side of the neighbourhood z of equation 3, over which a surface is
            summed [px]. 0, the pixel alone, so that an isolated event scores 0 (assumed).
        averaging: what a cell's sum is divided by. The number of events, equation 5.
        spacing_cells: sd, shortest correlation distance [cells]. Table I.
        spacings: n_c, number of correlation distances. Table I.
        g_m: gain of the motion response in steering [cells]. Table I.
        g_p: gain of the position response in steering [cells]. Table I.
        alpha: share of the new response in the steering low-pass; Δt / (Δt + τ_s) with τ_s = Δt.
            Assumed.
        exponent_cap: largest exponent of the position response. 4, reached at half the grid's
            side; from there on every shift ends on its target anyway (assumed).
        roi_radius_px: R, half side of the search square [px]. Table I, read as sensor pixels.
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
        response_scale: response per grid cell that the sigmoid scales by. One value by day and by
            night: with 3, simulated crossings at 0.9 rad/s (day, night) and 3.0 rad/s, faster and
            slower than any that is judged on, have medians of 0.22, 0.36, 0.91 and 0.95 with
            samples up to 4 px apart (assumed).
        floor: least strength that counts as motion. 0.00033 is a response of 20, above the 14
            that drawn noise of 10 Hz a pixel reaches without attention (assumed).
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
    cell_px: int = 3
    neighbourhood_px: int = 0
    averaging: Averaging = Averaging.EVENTS
    spacing_cells: int = 4
    spacings: int = 4
    g_m: float = 5.0
    g_p: float = 30.0
    alpha: float = 0.5
    exponent_cap: float = 4.0
    roi_radius_px: int = 50
    roi_smoothing_cells: int = 4
    roi_share: float = 0.1
    saliency_radius_cells: int = 8
    saliency_floor: float = 0.1
    response_scale: float = 3.0
    floor: float = 0.00033
    quiet_limit_us: int = 60_000_000

    @property
    def window_hops(self) -> int:
        """Hops in a window."""
        return self.window_us // self.hop_us

    @property
    def delay_hops(self) -> int:
        """Hops by which the delayed signal lags."""
        return self.delay_us // self.hop_us

    @property
    def roi_reach_cells(self) -> float:
        """R in cells."""
        return self.roi_radius_px / self.cell_px

    def __post_init__(self) -> None:
        """Check every value, and bring it to its type."""
        for name, default in _defaults().items():
            value = getattr(self, name)
            if isinstance(default, Averaging):
                checked: object = _choice(name, value)
            else:
                checked = _number(name, value, default)
            object.__setattr__(self, name, checked)
        self._check_times()

    def _check_times(self) -> None:
        for name in ("window_us", "delay_us"):
            if getattr(self, name) % self.hop_us:
                raise DetectorConfigError(
                    f"{name} is {getattr(self, name)} µs, no multiple of hop_us = {self.hop_us} "
                    "µs; allowed are whole multiples; choose a hop that divides it"
                )
        if self.window_hops + self.delay_hops > _MOST_HOPS:
            raise DetectorConfigError(
                f"hop_us is {self.hop_us} µs, which cuts window_us + delay_us into "
                f"{self.window_hops + self.delay_hops} hops; allowed are {_MOST_HOPS}, for each is "
                "kept in memory; choose a longer hop"
            )
        if self.quiet_limit_us < self.window_us + self.delay_us:
            raise DetectorConfigError(
                f"quiet_limit_us is {self.quiet_limit_us} µs; allowed is window_us + delay_us = "
                f"{self.window_us + self.delay_us} µs or more, else it cuts off what is still seen"
            )


def _defaults() -> dict[str, Any]:
    return {field.name: field.default for field in fields(FlyConfig)}


def _choice(name: str, value: Any) -> Averaging:
    try:
        return Averaging(value)
    except ValueError:
        allowed = ", ".join(repr(choice.value) for choice in Averaging)
        raise DetectorConfigError(
            f"{name} is {value!r}; allowed is one of {allowed}; the paper's value is "
            f"{_defaults()[name].value!r}"
        ) from None


def _number(name: str, value: Any, default: int | float) -> int | float:
    """The value as an int where the default is one, else as a float."""
    low, high = _RANGES[name]
    kind, whole = (Integral, "a whole number from ") if isinstance(default, int) else (Real, "")
    is_number = isinstance(value, kind) and not isinstance(value, bool)
    if not (is_number and low <= value <= high):
        raise DetectorConfigError(
            f"{name} is {value!r}; allowed is {whole}{low:g} to {high:g}; the paper's or the "
            f"assumed value is {default}"
        )
    return type(default)(value)


_MOST_HOPS = 1000
"""Most hops kept: 323 MB with the default grid (assumed)."""

_RANGES: dict[str, tuple[float, float]] = {
    "tau_us": (1, 10_000_000),
    "window_us": (1, 10_000_000),
    "hop_us": (1, 10_000_000),
    "delay_us": (1, 10_000_000),
    "cell_px": (1, 64),
    "neighbourhood_px": (0, 10),
    "spacing_cells": (1, 1000),
    "spacings": (1, 100),
    "g_m": (0.0, 1000.0),
    "g_p": (0.0, 1000.0),
    "alpha": (0.01, 0.99),
    "exponent_cap": (0.01, 100.0),
    "roi_radius_px": (1, 10_000),
    "roi_smoothing_cells": (0, 50),
    "roi_share": (0.001, 1.0),
    "saliency_radius_cells": (0, 50),
    "saliency_floor": (0.0, 1000.0),
    "response_scale": (1e-6, 1000.0),
    "floor": (1e-6, 0.999),
    "quiet_limit_us": (1, 3_600_000_000),
}
