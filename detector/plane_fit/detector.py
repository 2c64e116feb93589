"""Local plane fits: image velocity from the slope of the surface of active events.

R. Benosman, C. Clercq, X. Lagorce, S.-H. Ieng and C. Bartolozzi, "Event-based visual flow", IEEE
Transactions on Neural Networks and Learning Systems 25 (2), 2014. Where an edge passes, the times
of the last events form a plane, t = a·x + b·y + c. The slope (a, b) points where the edge goes
and is as long as the edge is slow. It tells no more than the motion across the edge (the aperture
problem), but a velocity v of the whole object obeys a·v_x + b·v_y = 1 for each of its edges: with
edges of several directions the least squares over a window give v.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.errors import DetectorConfigError
from detector.estimate import MotionEstimate
from detector.fly.tangential import winner_take_all, within_one
from detector.plane_fit.surface_slopes import SurfaceSlopes
from detector.windowed import WindowedDetector, check_whole_hops
from flybench.checks import Range, check_ranges
from flybench.events import Events
from flybench.kernels import compiled

__all__ = ["PlaneFit", "PlaneFitConfig"]

F64 = npt.NDArray[np.float64]

_ROUNDS = 10
"""Rounds of reweighting (assumed): afterwards drawn velocities change by less than 0.1 %."""
_RIDGE = 1e-3
"""Share by which slow velocities are preferred, which decides where edges do not tell (assumed)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneFitConfig:
    """Parameters of `PlaneFit`. None was chosen on the sequences that methods are judged on.

    Attributes:
        window_us: span of the fits that one estimate is made of [µs]. The event-driven fly's Δt.
        hop_us: step between estimates [µs]; windows are multiples of it. The fly's.
        radius_px: half side of the square that a plane is fitted to [px]. 2: 5×5 (assumed; the
            source has 3×3 and 5×5).
        span_us: how much older than its event a neighbour may be [µs]. 100 ms: an edge of 25 px/s
            crosses the square (assumed).
        burst_us: an event this soon after another of its pixel and polarity belongs to the same
            edge, and does not count [µs]. 4 ms (assumed): a sharp edge of 50 px/s makes events
            that close together, and the edges of one polarity at 1500 px/s are 6 px apart.
        least_neighbours: least number of neighbours in a fit. 10 of the 15 that an edge has swept
            (assumed): of drawn textures, that leaves out nearly all fits across several edges.
        tolerance_px: how far a neighbour may lie off the plane, as the way that the edge goes in
            that time [px]. 0.5 (assumed): half a pixel, which is how exactly events know where
            they are.
        limit_px_s: speed of which hs or vs is 1 [px/s]; faster fits are left out. 1500, as
            `ContrastConfig`.
        least_fits: of fewer, no velocity is given (assumed).
        snr_floor: least ratio of velocity to its standard error that counts as motion. 5
            (assumed): fits share neighbours and are not quite independent.

    Raises:
        DetectorConfigError: a value of another type or outside its range.
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
        """Check every value, and bring it to its type."""
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
    """The velocity that fits most edges: least squares, reweighted for outliers.

    For the unit normal n of an edge and its speed s across itself, n·v = s. Residuals are taken
    relative to the speed: a slope's error grows with its time.

    Args:
        slopes: (n, 2), (a, b) of each fit, one at least [s/px].

    Returns:
        v [px/s], and |v| over its standard error along v. Where all edges have one direction, v
        is the slowest that fits: straight across them.
    """
    vx, vy, ratio = _reweighted(slopes)
    return (vx, vy), ratio


@compiled
def _reweighted(slopes: Any) -> tuple[float, float, float]:
    """Velocity (x, y) [px/s] and |v| over its standard error; see `common_velocity`."""
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

    Its response is the velocity [px/s]; hs and vs are its shares of `limit_px_s`. It attends
    nowhere: its view centre is the image's.
    """

    def __init__(
        self, config: PlaneFitConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 with an empty memory.

        Args:
            config: parameters; the defaults where None.
            width: sensor columns [px].
            height: sensor rows [px].
        """
        self.config = c = config or PlaneFitConfig()
        super().__init__(c.hop_us, width=width, height=height)
        self._surface = SurfaceSlopes(
            width=width,
            height=height,
            radius_px=c.radius_px,
            span_us=c.span_us,
            burst_us=c.burst_us,
            least_neighbours=c.least_neighbours,
            tolerance_px=c.tolerance_px,
        )
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
        hs, vs = (within_one(v / c.limit_px_s) for v in velocity)
        return MotionEstimate(
            t_us=end_us,
            hs=hs,
            vs=vs,
            direction=winner_take_all(hs, vs, snr=(ratio, ratio), snr_floor=c.snr_floor),
            strength=max(abs(hs), abs(vs)),
            response=velocity,
            view_centre_px=(self._width / 2, self._height / 2),
            roi_px=None,
        )
