"""The fly: the paper's Section II, streaming over events in chunks of any size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from detector.attention import ViewCentre, saliency_map
from detector.correlation import t4, t5
from detector.errors import DetectorConfigError
from detector.estimate import MotionEstimate
from detector.fly_config import FlyConfig
from detector.region import region_of_interest
from detector.stream import check_chunk, check_order, whole_time
from detector.tangential import (
    horizontal_system,
    lobula_plate,
    normalise,
    vertical_system,
    winner_take_all,
)
from detector.time_surface import TimeSurfaces
from emulator.events import Events

__all__ = ["FlyConfig", "FlyDetector", "FlyMaps"]

F32 = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class FlyMaps:
    """What the fly saw at its last estimate, for display; made anew at each, never changed.

    Attributes:
        on: ON surface, (rows, columns) float32, one value per cell, dimensionless.
        off: OFF surface, same shape.
        motion: T4 + T5, (4, rows, columns) float32, planes right, left, up, down.
        saliency: smoothed H_on + H_off, (rows, columns) float32.
        attended: region of interest, (rows, columns) bool.
        cell_px: side of a cell [px].
    """

    on: F32
    off: F32
    motion: F32
    saliency: F32
    attended: npt.NDArray[np.bool_]
    cell_px: int


class FlyDetector:
    """Direction of motion from events, as the fly's optic lobe would (paper, Section II).

    Operating range with the default parameters: a drawn car of 200 px is told right in every step
    from 180 to 790 px/s (noise to 10 Hz a pixel); above, steps go wrong, and below some 100 px/s,
    where an object covers less than the shortest correlation distance, the sign can flip.

    It gives an estimate at every whole multiple of the hop from time 0 on. After
    `quiet_limit_us` without an event it sleeps: estimates stop, and go on with the hop of the next
    event, so that a gap of hours costs no more than one of a minute. By then everything is
    forgotten. A stream that begins later than that limit starts with the hop of its first event.
    """

    def __init__(
        self, config: FlyConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 with an empty memory, looking at the image centre.

        Args:
            config: parameters; the paper's where None.
            width: sensor columns [px].
            height: sensor rows [px].

        Raises:
            DetectorConfigError: the sensor has no room for one correlation distance.
        """
        self.config = c = config or FlyConfig()
        least = (c.spacing_cells + 1) * c.cell_px
        if min(width, height) < least or max(width, height) > 32_767:
            raise DetectorConfigError(
                f"the sensor is {width}×{height} px; allowed is {least} to 32767 px a side with "
                f"cells of {c.cell_px} px and spacing_cells = {c.spacing_cells}; lower these"
            )
        self._width, self._height = width, height
        self._surfaces = TimeSurfaces(c, width=width, height=height)
        grid = self._surfaces.rows, self._surfaces.columns
        home = width / 2 / c.cell_px - 0.5, height / 2 / c.cell_px - 0.5
        self._centre = ViewCentre(c, grid=grid, home=home)
        self._hop = 0
        self._now_us: int | None = None
        self._last_event_us = 0
        self._blank_maps = _blank_maps(grid, c.cell_px)
        self.maps = self._blank_maps

    def push(self, events: Events) -> list[MotionEstimate]:
        """Take the next events of the stream; see `Detector.push`.

        Raises:
            EventError: not a sorted stream of `EVENT_DTYPE` from this sensor.
            EventOrderError: the first event is older than what was passed or advanced to before.
        """
        check_chunk(events, width=self._width, height=self._height, now_us=self._now_us or 0)
        if events.size == 0:
            return []
        first_us = int(events["t"][0])
        if self._now_us is None and first_us > self.config.quiet_limit_us:
            self._hop = first_us // self.config.hop_us
        estimates: list[MotionEstimate] = []
        taken = 0
        while True:
            hop_end_us = (self._hop + 1) * self.config.hop_us
            taken += self._surfaces.accumulate(events[taken:], hop=self._hop, until_us=hop_end_us)
            if taken:
                self._last_event_us = int(events["t"][taken - 1])
            if taken == events.size:
                break
            estimates += self._due(int(events["t"][taken]))
        self._now_us = self._last_event_us
        return estimates

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Learn that every event before `t_us` was passed; see `Detector.advance`.

        Raises:
            EventOrderError: `t_us` is before what was passed or advanced to before, or is no whole
                number.
        """
        t_us = whole_time(t_us)
        check_order(t_us, self._now_us or 0)
        self._now_us = t_us
        return self._due(t_us)

    def _due(self, t_us: int) -> list[MotionEstimate]:
        """Estimates of the windows that end at or before `t_us`, as far as the fly is awake."""
        estimates = []
        hop_us = self.config.hop_us
        while (end_us := (self._hop + 1) * hop_us) <= t_us:
            if end_us - self._last_event_us > self.config.quiet_limit_us:
                self._hop = t_us // hop_us
                break
            estimates.append(self._estimate(end_us))
            self._hop += 1
            self._surfaces.begin_hop(self._hop)
        return estimates

    def _estimate(self, end_us: int) -> MotionEstimate:
        c = self.config
        if self._surfaces.is_quiet:
            self._centre.release()
            self.maps = self._blank_maps
        else:
            self.maps = self._see()
        lp = lobula_plate(self.maps.motion, self.maps.attended)
        response = horizontal_system(lp), vertical_system(lp)
        cells = self.maps.attended.size
        hs, vs = (normalise(r, cells=cells, scale=c.response_scale) for r in response)
        x, y = self._centre.position
        return MotionEstimate(
            t_us=end_us,
            hs=hs,
            vs=vs,
            direction=winner_take_all(hs, vs, floor=c.floor),
            strength=max(abs(hs), abs(vs)),
            response=response,
            view_centre_px=((x + 0.5) * c.cell_px, (y + 0.5) * c.cell_px),
            roi_px=self._roi_px(),
        )

    def _see(self) -> FlyMaps:
        c = self.config
        off, on = self._surfaces.average(hop=self._hop)
        off_delayed, on_delayed = self._surfaces.average(hop=self._hop - c.delay_hops)
        t4_maps = t4(on, on_delayed, spacing=c.spacing_cells, count=c.spacings)
        t5_maps = t5(off, off_delayed, spacing=c.spacing_cells, count=c.spacings)
        motion = t4_maps + t5_maps
        saliency = saliency_map(on, off, radius=c.saliency_radius_cells)
        self._centre.update(saliency, motion)
        attended = self._blank_maps.attended
        if self._centre.is_attending:
            # The delayed arm of a correlation lies behind the present one: both make the region.
            activity = saliency_map(
                on + on_delayed, off + off_delayed, radius=c.roi_smoothing_cells
            )
            attended = region_of_interest(
                activity,
                self._centre.position,
                reach=c.roi_reach_cells,
                share=c.roi_share,
            )
        return FlyMaps(on, off, motion, saliency, attended, c.cell_px)

    def _roi_px(self) -> tuple[int, int, int, int] | None:
        attended, side = self.maps.attended, self.config.cell_px
        rows = np.flatnonzero(attended.any(axis=1))
        if rows.size == 0:
            return None
        columns = np.flatnonzero(attended.any(axis=0))
        x0, y0 = int(columns[0]) * side, int(rows[0]) * side
        x1, y1 = (int(columns[-1]) + 1) * side, (int(rows[-1]) + 1) * side
        return x0, y0, min(x1, self._width), min(y1, self._height)


def _blank_maps(grid: tuple[int, int], cell_px: int) -> FlyMaps:
    blank = np.zeros(grid, np.float32)
    return FlyMaps(
        on=blank,
        off=blank,
        motion=np.zeros((4, *grid), np.float32),
        saliency=blank,
        attended=np.zeros(grid, np.bool_),
        cell_px=cell_px,
    )
