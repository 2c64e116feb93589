"""Local plane fits: image velocity from the slope of the surface of active events.

R. Benosman, C. Clercq, X. Lagorce, S.-H. Ieng and C. Bartolozzi, "Event-based visual flow", IEEE
Transactions on Neural Networks and Learning Systems 25 (2), 2014. Where an edge passes, the times
of the last events form a plane, t = a·x + b·y + c. The slope (a, b) points in the direction in
which the edge moves, and its length is the inverse of the edge's speed. It gives only the motion
across the edge (the aperture problem). But a velocity v of the whole object satisfies
a·v_x + b·v_y = 1 for each of its edges, so that with edges of several directions, least squares
over a window give v.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.decision import velocity_estimate
from detector.errors import DetectorConfigError
from detector.estimate import MotionEstimate
from detector.plane_fit.surface_slopes import FitLimits, SurfaceSlopes
from detector.windowed import WindowedDetector, check_whole_hops
from flybench.checks import Range, check_ranges
from flybench.events import Events
from flybench.kernels import compiled
from flybench.memory import count_memory

__all__ = ["PlaneFit", "PlaneFitConfig"]

F64 = npt.NDArray[np.float64]

_BYTES_PER_PX = 33
"""Memory of the two surfaces per pixel, without the events [bytes]."""
_ROUNDS = 10
"""Rounds of reweighting (assumed). Further rounds change velocities of synthetic stimuli by less
than 0.1 %."""
_RIDGE = 1e-3
"""Relative preference for slow velocities, which decides where edges of one direction leave the
velocity open (assumed)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneFitConfig:
    """Parameters of `PlaneFit`. No value was chosen on the sequences used for evaluation.

    Attributes:
        window_us: span of the fits of one estimate [µs]. Δt of the event-driven fly.
        hop_us: step between estimates [µs]; the window is a multiple of it. That of the
            event-driven fly.
        radius_px: half side of the square in which a plane is fitted [px]. 2: 5×5 (assumed; the
            source has 3×3 and 5×5).
        span_us: greatest age of a neighbour relative to its event [µs]. 100 ms: an edge of 25 px/s
            crosses the square in that time (assumed).
        burst_us: an event this soon after another of its pixel and polarity belongs to the same
            edge and is not used [µs]. The default of 4 ms is the spacing of the events of a sharp
            edge at 50 px/s; at 1500 px/s, it separates edges of one polarity that are 6 px apart
            (assumed).
        least_neighbours: least number of neighbours in a fit. 10 of the 15 that an edge has swept:
            on synthetic textures, this excludes nearly all fits across several edges (assumed).
        tolerance_px: greatest distance of a neighbour from the plane, as the distance that the edge
            moves in that time [px]. 0.5: half a pixel, the precision of an event's position
            (assumed).
        limit_px_s: speed at which hs or vs is 1 [px/s]; faster fits are excluded. 1500, as in
            `ContrastConfig`.
        least_fits: least number of fits for a velocity (assumed).
        snr_floor: least ratio of the velocity to its standard error that counts as motion. 5: fits
            share neighbours and are not quite independent (assumed).

    Raises:
        DetectorConfigError: a value has the wrong type or is out of range.
    """

    window_us: int = 50_000
    hop_us: int = 10_000
    radius_px: int = 2
    span_us: int = 100_000
    burst_us: int = 4_000
    least_neighbours: int = 10
    tolerance_px: float = 0.5
    limit_px_s: float = 1500.0
    least_fits: int = 20
    snr_floor: float = 5.0

    def __post_init__(self) -> None:
        """Check every value and convert it to its type."""
        check_ranges(self, _RANGES, DetectorConfigError)
        check_whole_hops(self.hop_us, window_us=self.window_us)


_RANGES: dict[str, Range] = {
    "window_us": Range(1000, 10_000_000),
    "hop_us": Range(1000, 10_000_000),
    "radius_px": Range(1, 10),
    "span_us": Range(1, 10_000_000),
    "burst_us": Range(0, 10_000_000),
    "least_neighbours": Range(3, 400),
    "tolerance_px": Range(0.01, 100.0),
    "limit_px_s": Range(1.0, 100_000.0),
    "least_fits": Range(3, 1_000_000),
    "snr_floor": Range(0.0, 1e6),
}


def common_velocity(slopes: F64) -> tuple[tuple[float, float], float]:
    """Return the velocity that fits most edges, by least squares reweighted for outliers.

    For the unit normal n of an edge and its speed s along n, n·v = s. Residuals are speeds, because
    the error of a slope grows with its time.

    Args:
        slopes: (a, b) of each fit, (n, 2) with n ≥ 1 [s/px].

    Returns:
        v [px/s], and |v| over its standard error along v. If all edges have one direction, v is the
        slowest velocity that fits, perpendicular to them.
    """
    vx, vy, ratio = _reweighted(slopes)
    return (vx, vy), ratio


@compiled
def _reweighted(slopes: Any) -> tuple[float, float, float]:
    """Return v_x, v_y [px/s] and |v| over its standard error; see `common_velocity`."""
    steepness = np.hypot(slopes[:, 0], slopes[:, 1])
    nx, ny, speeds = slopes[:, 0] / steepness, slopes[:, 1] / steepness, 1.0 / steepness
    weights = np.ones_like(speeds)
    vx = vy = xx = xy = yy = 0.0
    residuals = speeds
    for _ in range(_ROUNDS):
        xx, xy, yy = (weights * nx * nx).sum(), (weights * nx * ny).sum(), (weights * ny * ny).sum()
        ridge = _RIDGE * (xx + yy)
        xx, yy = xx + ridge, yy + ridge
        px, py = (weights * nx * speeds).sum(), (weights * ny * speeds).sum()
        determinant = xx * yy - xy * xy
        vx, vy = (yy * px - xy * py) / determinant, (xx * py - xy * px) / determinant
        residuals = nx * vx + ny * vy - speeds
        spread = 1.4826 * np.median(np.abs(residuals)) + 1e-9
        weights = 1.0 / (1.0 + (residuals / spread) ** 2)
    variance, speed = (weights * residuals**2).sum() / weights.sum(), np.hypot(vx, vy)
    if speed == 0.0 or variance == 0.0:
        return vx, vy, 0.0
    spread_along = (yy * vx * vx - 2 * xy * vx * vy + xx * vy * vy) / (xx * yy - xy * xy)
    return vx, vy, speed**2 / math.sqrt(variance * spread_along)


class PlaneFit(WindowedDetector):
    """Local plane fits as a `Detector`: the common velocity of a window's edges at every hop.

    Its response is the image velocity [px/s]; hs and vs are its components relative to
    `limit_px_s`. It has no attention: its view centre is the image centre.

    Attributes:
        config: parameters.
        memory_us: age of the oldest event in an estimate: a neighbour of a fit at the start of the
            window [µs].
    """

    def __init__(
        self, config: PlaneFitConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 without events.

        Args:
            config: parameters; None: the defaults.
            width: sensor columns [px].
            height: sensor rows [px].

        Raises:
            MemoryBudgetError: the sensor is too large for the memory budget.
        """
        self.config = c = config or PlaneFitConfig()
        super().__init__(c.hop_us, c.window_us, width=width, height=height)
        count_memory(self, f"A plane fit of {width}×{height} px", _BYTES_PER_PX * width * height)
        self.memory_us = c.window_us + c.span_us
        limits = FitLimits(c.radius_px, c.span_us, c.burst_us, c.least_neighbours, c.tolerance_px)
        self._surface = SurfaceSlopes(limits, width=width, height=height)
        hops = c.window_us // c.hop_us
        self._window = deque([np.empty((0, 2), np.float64)] * hops, maxlen=hops)

    def _estimate(self, end_us: int, events: Events) -> MotionEstimate:
        c = self.config
        slopes = self._surface.fit(events)
        steepness = np.hypot(slopes[:, 0], slopes[:, 1])
        self._window.append(slopes[steepness * c.limit_px_s > 1.0])
        slopes = np.concatenate(self._window)
        velocity, ratio = (0.0, 0.0), 0.0
        if len(slopes) >= c.least_fits:
            velocity, ratio = common_velocity(slopes)
        return velocity_estimate(
            end_us,
            velocity,
            limit_px_s=c.limit_px_s,
            ratio=ratio,
            ratio_floor=c.snr_floor,
            image_centre_px=(self._width / 2, self._height / 2),
        )
