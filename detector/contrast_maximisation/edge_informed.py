"""Edge-informed contrast maximisation: the image of warped events also has to fit a frame's edges.

P. P. Karmokar, Q. H. Nguyen and W. J. Beksi, "Secrets of edge-informed contrast maximization for
event-based vision", WACV 2025. The method estimates a flow for each pixel and has a smoothness term
and a pyramid of flows for that. Here there is one velocity for a window, as in
`detector.contrast_maximisation.detector`, with its search and its noise floor; the reward is the
paper's. Parameters are those of the code that the authors published
(robotic-vision-lab/Edge-Informed-Contrast-Maximization), unless marked as assumed.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from detector.contrast_maximisation.detector import (
    ContrastConfig,
    ContrastEstimate,
    ContrastMaximisation,
    with_prominence,
)
from detector.contrast_maximisation.search import Velocity, search_cold, search_warm
from detector.contrast_maximisation.warped_events import WarpedEvents, centred_points
from detector.errors import DetectorConfigError, FrameError
from detector.estimate import MotionEstimate
from flybench.checks import Range, check_ranges
from flybench.events import Events
from flybench.kernels import compiled

__all__ = ["EdgeInformedConfig", "EdgeInformedContrast"]

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

_MOST_FRAMES = 64
"""Largest number of frames in a window; of more, the last ones are used (assumed)."""
_REFERENCE_SIGMAS = 1.5
"""Several frames of a window are weighted by a normal density over this many standard deviations to
either side of the middle one."""
_DENOISE, _TEMPLATE_PX, _SEARCH_PX = 4, 3, 11
_CLIP_LIMIT, _TILES = 5, (10, 10)
_BLUR_SIGMA_PX, _SHARPEN = 2, 1.5
_BILATERAL_PX, _BILATERAL_SIGMA = 5, 15
"""Denoising, equalisation, sharpening and smoothing of a frame before its edges are found."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EdgeInformedConfig(ContrastConfig):
    """Parameters of `EdgeInformedContrast`: those of `ContrastConfig`, and of the edges.

    No value was chosen on the sequences that detectors are evaluated on.

    Attributes:
        contrast_weight: α, weight of the contrast relative to that of events that are not warped.
        edge_weight: β, weight of the mean squared difference from the edges, relative to that of
            events that are not warped.
        canny_low: lower threshold of the Canny edges, for grey levels of 8 bits.
        canny_high: upper threshold of the Canny edges.
        edge_fall_px: distance from an edge at which the image of edges falls to 1/e [px].
    """

    contrast_weight: float = 20.0
    edge_weight: float = 35.0
    canny_low: float = 100.0
    canny_high: float = 200.0
    edge_fall_px: float = 6.0 / 5.541

    def __post_init__(self) -> None:
        """Check every value and convert it to its type."""
        ContrastConfig.__post_init__(self)
        check_ranges(self, _RANGES, DetectorConfigError)


_RANGES: dict[str, Range] = {
    "contrast_weight": Range(0.0, 1e6),
    "edge_weight": Range(0.0, 1e6),
    "canny_low": Range(0.0, 1e5),
    "canny_high": Range(0.0, 1e5),
    "edge_fall_px": Range(0.01, 1e4),
}


def edge_image(frame: npt.NDArray[np.uint16], config: EdgeInformedConfig) -> F32:
    """Return 1 on the edges of a frame, falling exponentially to 0 with the distance.

    Args:
        frame: (height, width) uint16, raw counts.
        config: thresholds and distance.

    Returns:
        (height, width) float32; zeros if the frame has no edge.
    """
    low, high = float(frame.min()), float(frame.max())
    grey = ((frame - low) * (255.0 / max(high - low, 1.0))).astype(np.uint8)
    calm = cv2.fastNlMeansDenoising(grey, None, _DENOISE, _TEMPLATE_PX, _SEARCH_PX)
    even = cv2.createCLAHE(_CLIP_LIMIT, _TILES).apply(calm)
    blurred = cv2.GaussianBlur(even, (0, 0), _BLUR_SIGMA_PX)
    sharp = cv2.addWeighted(even, _SHARPEN, blurred, 1.0 - _SHARPEN, 0.0)
    smooth = cv2.bilateralFilter(sharp, _BILATERAL_PX, _BILATERAL_SIGMA, _BILATERAL_SIGMA)
    edges = cv2.Canny(smooth, config.canny_low, config.canny_high, L2gradient=True)
    if not edges.any():
        return np.zeros(frame.shape, np.float32)
    distance = cv2.distanceTransform(255 - edges, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(np.exp(-distance / config.edge_fall_px), np.float32)


class EdgeRewards:
    """Rewards of candidate velocities: contrast, and agreement with the edges of frames.

    The reward of v is α·C(v)/C(0) − β·Σ w·D(v)/D(0), with the contrast C, and the mean squared
    difference D between the edges of a frame and the image of the events, warped to the time of the
    frame and scaled to 0 to 1. Without a frame it is α·C(v)/C(0).
    """

    def __init__(
        self,
        warped: WarpedEvents,
        references: Sequence[tuple[F32, F32]],
        config: EdgeInformedConfig,
    ) -> None:
        """Prepare the rewards.

        Args:
            warped: the events, for the contrast.
            references: for each frame, the events with their times from that of the frame, (3, n),
                and from the first pixel, and its edges, (height, width).
            config: the weights.
        """
        self._warped, self._references, self._config = warped, references, config
        at = np.linspace(-_REFERENCE_SIGMAS, _REFERENCE_SIGMAS, max(len(references), 1))
        weights = np.exp(-(at**2) / 2)
        self._weights = weights / weights.sum()
        self._unwarped: dict[float, tuple[float, list[float]]] = {}

    def __call__(self, velocities: F64, scale_px: float) -> F64:
        """Return the rewards of (n, 2) velocities [px/s] with image pixels of a side [px]."""
        if scale_px not in self._unwarped:
            contrast, differences = self._terms(np.zeros((1, 2)), scale_px)
            self._unwarped[scale_px] = float(contrast[0]), [float(d[0]) for d in differences]
        contrast_0, differences_0 = self._unwarped[scale_px]
        contrast, differences = self._terms(velocities, scale_px)
        c = self._config
        rewards = c.contrast_weight * contrast / (contrast_0 or 1.0)
        for weight, found, before in zip(self._weights, differences, differences_0, strict=False):
            rewards -= c.edge_weight * weight * found / (before or 1.0)
        return np.asarray(rewards, np.float64)

    def _terms(self, velocities: F64, scale_px: float) -> tuple[F64, list[F64]]:
        """Return the contrast of each velocity, and its difference from each frame's edges."""
        differences = []
        for points, edges in self._references:
            shape = tuple(math.ceil(size / scale_px) for size in edges.shape)
            small = cv2.resize(edges, shape[::-1], interpolation=cv2.INTER_AREA)
            found = np.zeros(len(velocities))
            image = np.zeros(shape, np.float32)
            squared_differences(points, velocities, 1.0 / scale_px, small, image, found)
            differences.append(found)
        return self._warped.rewards(velocities, scale_px), differences


@compiled
def squared_differences(
    points: Any, velocities: Any, per_px: float, edges: Any, image: Any, found: Any
) -> None:
    """Write the mean squared difference between edges and warped events for each velocity.

    The image has bilinear votes of the events that are warped into it, divided by its maximum.
    """
    rows, columns = image.shape
    for n in range(velocities.shape[0]):
        image[:] = np.float32(0.0)
        for k in range(points.shape[1]):
            x = (points[0, k] + 0.5 - velocities[n, 0] * points[2, k]) * per_px - 0.5
            y = (points[1, k] + 0.5 - velocities[n, 1] * points[2, k]) * per_px - 0.5
            column, row = int(np.floor(x)), int(np.floor(y))
            right, below = np.float32(x - column), np.float32(y - row)
            for j in range(2):
                for i in range(2):
                    if 0 <= row + j < rows and 0 <= column + i < columns:
                        share = right if i else np.float32(1.0) - right
                        share *= below if j else np.float32(1.0) - below
                        image[row + j, column + i] += share
        highest = max(float(image.max()), 1e-6)
        total = 0.0
        for row in range(rows):
            for column in range(columns):
                total += (edges[row, column] - image[row, column] / highest) ** 2
        found[n] = total / (rows * columns)


class EdgeInformedContrast(ContrastMaximisation):
    """Edge-informed contrast maximisation as a `FrameDetector`.

    It answers as `ContrastMaximisation` does, and to the same events alike if no frame ends in the
    window. A frame counts at the end of its exposure (assumed: exposures are short).
    """

    config: EdgeInformedConfig

    def __init__(
        self, config: EdgeInformedConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 without events and frames; arguments as for `ContrastMaximisation`."""
        super().__init__(config or EdgeInformedConfig(), width=width, height=height)
        self._edges: deque[tuple[int, F32]] = deque(maxlen=_MOST_FRAMES)

    def push_frame(self, t_us: int, frame: npt.NDArray[np.uint16]) -> list[MotionEstimate]:
        """Process the next frame; see `FrameDetector.push_frame`.

        Raises:
            FrameError: the frame is not a (height, width) uint16 array.
            EventOrderError: `t_us` is before an event or a time that was passed before, or is not a
                whole number.
        """
        shape, kind = (self._height, self._width), type(frame).__name__
        if isinstance(frame, np.ndarray):
            kind = f"{frame.dtype} and shape {frame.shape}"
        if kind != f"uint16 and shape {shape}":
            raise FrameError(
                f"The frame is of type {kind}. Allowed is a uint16 array of shape {shape}. Pass "
                "the raw counts of the sensor, or make a detector of its size."
            )
        due = self.advance(t_us)
        self._edges.append((t_us, edge_image(frame, self.config)))
        return due

    def _maximise(self, events: Events, end_us: int) -> ContrastEstimate | None:
        c, from_us = self.config, end_us - self.config.window_us
        frames = [(t_us, edges) for t_us, edges in self._edges if from_us <= t_us < end_us]
        if not frames or events.size < c.least_events:
            return super()._maximise(events, end_us)
        window_s = c.window_us * 1e-6
        reach = c.limit_px_s * window_s
        area_px = (self._width + reach) * (self._height + reach)
        middle_px = ((self._width - 1) / 2, (self._height - 1) / 2)

        def rewards_of(number: int) -> tuple[WarpedEvents, EdgeRewards]:
            middle_us = end_us - c.window_us / 2
            points = centred_points(events, most=number, middle_us=middle_us, middle_px=middle_px)
            references = [
                (centred_points(events, most=number, middle_us=t_us, middle_px=(0.0, 0.0)), edges)
                for t_us, edges in frames
            ]
            warped = WarpedEvents(points, reward=c.reward, area_px=area_px)
            return warped, EdgeRewards(warped, references, c)

        warped, rewards = rewards_of(c.most_events)
        _, survey = rewards_of(_SCAN_EVENTS)
        limits = {"window_s": window_s, "limit_px_s": c.limit_px_s}
        if self._previous is not None:
            velocity: Velocity = search_warm(rewards, survey, self._previous, **limits)
            found = with_prominence(warped, velocity, is_cold=False)
            if found.prominence >= c.prominence_floor and math.hypot(*velocity) <= c.limit_px_s:
                return found
        velocity = search_cold(rewards, cold_scan_at=survey, **limits)
        return with_prominence(warped, velocity, is_cold=True)


_SCAN_EVENTS = 2500
"""Number of events with which a search scans all velocities, as in a warm search of contrast
maximisation (assumed)."""
