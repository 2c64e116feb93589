"""How far things move from one frame to the next, and what lies between.

The sensor takes light as ramping from one frame to the next. Where an edge moves by more than a
pixel, that is not what happened: the pixels between would have changed one after another, and all
of them change at once. Optical flow is DIS (Kroeger et al. 2016), of OpenCV; between two frames
pictures are warped from both sides, along the flow that Jiang et al. (2018, "Super SloMo",
equation 4) put together for a moment between, without what they learn.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

F32 = npt.NDArray[np.float32]
U8 = npt.NDArray[np.uint8]

CHANGED = 3
"""Grey levels of 255 by which a pixel must differ to count as one where something moves
(assumed: above the noise of compression)."""
SLOPE = 1.0
"""Grey levels a pixel above which the picture has a slope, along which motion is measured (assumed:
what is flatter gives no flow)."""
QUANTILE = 0.95
"""Of the displacements there, what counts as the motion: the flow's outliers do not."""
MOST_BETWEEN = 200
"""Most pictures that are made between two frames (assumed)."""
GAMMA = 2.2
"""Of the grey levels in which flow is looked for, so that dark and bright count alike."""


class MotionMeter:
    """Optical flow between frames of light."""

    def __init__(self, white_cd_m2: float) -> None:
        """Levels are counted up to this luminance [cd/m²]."""
        self._white = white_cd_m2
        self._dis: Any = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)

    def flow_px(self, before: F32, after: F32) -> F32:
        """(rows, columns, 2) where what is at a pixel before has gone by after [px]."""
        return np.asarray(
            self._dis.calc(self._levels(before), self._levels(after), None), np.float32
        )

    def motion_px(self, before: F32, after: F32, flow_px: F32) -> float:
        """Displacement of what moves: the 95th percentile where light has changed [px].

        Only what is along the picture's gradient counts: along a bar or a stripe nobody can tell
        how far it moved (the aperture problem), and flow there is anything.
        """
        levels = self._levels(before), self._levels(after)
        across, down = (
            cv2.Sobel(levels[0], cv2.CV_32F, dx, dy, scale=1 / 8) for dx, dy in ((1, 0), (0, 1))
        )
        slope = np.hypot(across, down)
        seen = (cv2.absdiff(*levels) >= CHANGED) & (slope > SLOPE)
        if not seen.any():
            return 0.0
        along = (flow_px[..., 0] * across + flow_px[..., 1] * down)[seen] / slope[seen]
        return float(np.quantile(np.abs(along), QUANTILE))

    def _levels(self, light: F32) -> U8:
        share = np.clip(light / np.float32(self._white), 0.0, 1.0)
        return np.asarray(np.rint(255 * share ** (1 / GAMMA)), np.uint8)


def pictures_between(motion_px: float, step_px: float) -> int:
    """How many it takes so that nothing moves farther than `step_px` at once."""
    return min(MOST_BETWEEN, max(0, math.ceil(motion_px / step_px) - 1))


def between(
    before: F32, after: F32, forth_px: F32, back_px: F32, number: int
) -> Iterator[tuple[float, F32]]:
    """Light at `number` moments between two frames.

    Args:
        before: (rows, columns) luminance [cd/m²].
        after: the same, later.
        forth_px: (rows, columns, 2) flow from before to after [px].
        back_px: flow from after to before [px].
        number: how many moments, evenly.

    Yields:
        The share of the time that has passed, in (0, 1), and the light then.
    """
    rows, columns = before.shape
    grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=2).astype(np.float32)
    for k in range(1, number + 1):
        t = k / (number + 1)
        to_before = -(1 - t) * t * forth_px + t * t * back_px
        to_after = (1 - t) ** 2 * forth_px - t * (1 - t) * back_px
        mixed = (1 - t) * _taken(before, grid + to_before) + t * _taken(after, grid + to_after)
        yield t, np.asarray(mixed, np.float32)


def _taken(light: F32, at: npt.NDArray[Any]) -> F32:
    places = at.astype(np.float32)
    return np.asarray(
        cv2.remap(
            light, places[..., 0], places[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        ),
        np.float32,
    )
