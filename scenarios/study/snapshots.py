"""Snapshots of a crossing for the figures: what the sensor and the fly saw."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyMaps
from detector.metrics import Box
from emulator import ApsFrame
from scenarios.study.results import Snapshot

SHARES_OF_CROSSING = (0.2, 0.4, 0.5, 0.6, 0.8)
"""Times of the snapshots, as shares of the time in view; the middle one represents the sequence."""
PERIOD_US = 20_000
"""Time between the snapshots that are kept to select from (assumed) [µs]."""


class SnapshotCollector:
    """Keeps snapshots while a crossing runs, and selects some once its duration is known."""

    def __init__(self) -> None:
        self._aps: ApsFrame | None = None
        self._method: str | None = None
        self._kept: list[Snapshot] = []

    def add_frames(self, frames: Sequence[ApsFrame]) -> None:
        """Add the next APS frames of the sensor."""
        self._aps = frames[-1] if frames else self._aps

    def add(self, method: str, estimate: MotionEstimate, maps: FlyMaps, box_px: Box | None) -> None:
        """Add the output of a fly.

        Only the first fly that is added counts, from the first APS frame on.

        Args:
            method: name of the method.
            estimate: estimate of the fly.
            maps: maps of the fly at the time of the estimate.
            box_px: true box of the vehicle at that time.
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

    def select(self, in_view_us: tuple[int, int]) -> tuple[Snapshot, ...]:
        """Return the snapshots nearest to `SHARES_OF_CROSSING`, in order and without duplicates."""
        if not self._kept:
            return ()
        times_us = np.array([shot.t_us for shot in self._kept])
        begin, end = in_view_us
        wanted = [begin + share * (end - begin) for share in SHARES_OF_CROSSING]
        chosen = sorted({int(np.abs(times_us - t_us).argmin()) for t_us in wanted})
        return tuple(self._kept[n] for n in chosen)
