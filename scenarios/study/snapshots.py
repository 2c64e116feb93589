"""Moments of a crossing for the figures: what the sensor and the fly saw."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyMaps
from detector.metrics import Box
from emulator import ApsFrame
from scenarios.study.results import Snapshot

SHARES_OF_CROSSING = (0.2, 0.4, 0.5, 0.6, 0.8)
"""When, from the first pixel in view to the last; the middle one stands for the sequence."""
PERIOD_US = 20_000
"""How far apart moments are kept of which one may be chosen (assumed)."""


class Album:
    """Keeps moments while a crossing runs, and gives those wanted once its length is known."""

    def __init__(self) -> None:
        self._aps: ApsFrame | None = None
        self._method: str | None = None
        self._kept: list[Snapshot] = []

    def add_frames(self, frames: Sequence[ApsFrame]) -> None:
        """Take the sensor's next frames."""
        self._aps = frames[-1] if frames else self._aps

    def add(self, method: str, estimate: MotionEstimate, maps: FlyMaps, box_px: Box | None) -> None:
        """Take what a fly saw, of the first fly that comes; nothing before the first frame.

        Args:
            method: its name.
            estimate: what it said.
            maps: of the same moment.
            box_px: the vehicle's true box then.
        """
        self._method = self._method or method
        is_due = not self._kept or estimate.t_us >= self._kept[-1].t_us + PERIOD_US
        if self._aps is None or method != self._method or not is_due:
            return
        self._kept.append(
            Snapshot(
                t_us=estimate.t_us,
                aps=self._aps.image,
                saliency=maps.saliency,
                cell_px=maps.cell_px,
                roi_px=estimate.roi_px,
                box_px=box_px,
            )
        )

    def choose(self, in_view_us: tuple[int, int]) -> tuple[Snapshot, ...]:
        """The moments kept that are nearest to `SHARES_OF_CROSSING`, in order; none twice."""
        if not self._kept:
            return ()
        times_us = np.array([shot.t_us for shot in self._kept])
        begin, end = in_view_us
        wanted = [begin + share * (end - begin) for share in SHARES_OF_CROSSING]
        chosen = sorted({int(np.abs(times_us - t_us).argmin()) for t_us in wanted})
        return tuple(self._kept[n] for n in chosen)
