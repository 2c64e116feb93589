"""The fly: the paper's Section II, streaming over events in chunks of any size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.errors import DetectorConfigError, StateError
from detector.estimate import MotionEstimate
from detector.event_checks import check_chunk, check_order, whole_time
from detector.fly.attention import ViewCentre, saliency_map
from detector.fly.config import FlyConfig
from detector.fly.correlation import t4, t5
from detector.fly.model_variants import Attention, Normalisation, RegionActivity
from detector.fly.region import region_of_interest
from detector.fly.state import State, check_arrays, check_origin, joined, origin, part_of
from detector.fly.tangential import (
    horizontal_system,
    lobula_plate,
    normalise,
    shares_of_total,
    signal_to_noise,
    vertical_system,
    winner_take_all,
)
from detector.fly.time_surface import TimeSurfaces
from flybench.events import Events

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

    Operating range, on drawn targets of 120 px in four directions: with the paper's parameters
    steps are right from 160 px/s on (up to 1500 px/s measured); below, the response is weak
    and may have the wrong sign, and the fly mostly says none. `FlyConfig.preset("wide")` is right
    from 30 to 1500 px/s, both in noise of up to 10 Hz a pixel.

    It gives an estimate at every whole multiple of the hop from time 0 on. After
    `quiet_limit_us` without an event it sleeps: estimates stop, and go on with the hop of the next
    event, so that a gap of hours costs no more than one of a minute. Asleep it forgets everything.
    A stream that begins later than that limit starts with the hop of its first event, and
    `advance` beyond the limit before that event gives nothing.
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
            DetectorConfigError: no `FlyConfig`, a side that is no whole number, or a sensor without
                room for one correlation distance.
        """
        self.config = c = _checked(FlyConfig() if config is None else config)
        width, height = _side("width", width), _side("height", height)
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
        self._blank_maps = _blank_maps(grid, c.cell_px)
        self.maps = self._blank_maps

    def push(self, events: Events) -> list[MotionEstimate]:
        """Take the next events of the stream; see `Detector.push`.

        Raises:
            EventError: not a sorted stream of `EVENT_DTYPE` from this sensor.
            EventOrderError: the first event is older than what was passed or advanced to before.
        """
        now_us = 0 if self._now_us is None else self._now_us
        check_chunk(events, width=self._width, height=self._height, now_us=now_us)
        if events.size == 0:
            return []
        self._wake(int(events["t"][0]))
        estimates: list[MotionEstimate] = []
        taken = 0
        while True:
            hop_end_us = (self._hop + 1) * self.config.hop_us
            taken = self._surfaces.accumulate(events, taken, until_us=hop_end_us)
            if taken == events.size:
                break
            estimates += self._due(int(events["t"][taken]))
        self._now_us = self._surfaces.last_event_us
        return estimates

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Learn that every event before `t_us` was passed; see `Detector.advance`.

        Raises:
            EventOrderError: `t_us` is before what was passed or advanced to before, too large, or
                no whole number.
        """
        t_us = whole_time(t_us)
        check_order(t_us, self._now_us or 0)
        self._now_us = t_us
        self._wake(t_us)
        return self._due(t_us)

    def state(self) -> State:
        """What the fly remembers, as plain arrays that `restore` takes.

        `np.savez(path, **fly.state())` keeps it. Its size follows the events of the last window,
        not the stream. The maps for display are not part of it.
        """
        now_us = -1 if self._now_us is None else self._now_us
        parts = {
            "fly": {"hop": np.array(self._hop), "now_us": np.array(now_us)},
            "surfaces": self._surfaces.state(),
            "centre": self._centre.state(),
        }
        return origin(self.config, width=self._width, height=self._height) | joined(parts)

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Go on where another fly was when its `state` was taken; the same estimates follow.

        Raises:
            StateError: it comes from another configuration or sensor, is not whole, or contradicts
                itself.
        """
        check_origin(state, origin(self.config, width=self._width, height=self._height))
        check_arrays(state, self.state(), loose={"surfaces.times", "surfaces.pixels"})
        hop, now_us = int(state["fly.hop"]), int(state["fly.now_us"])
        if hop != max(now_us, 0) // self.config.hop_us:
            raise StateError(
                f"the state is in hop {hop} at {now_us} µs; allowed is the hop of that time, "
                f"{max(now_us, 0) // self.config.hop_us}; pass what FlyDetector.state() gave, whole"
            )
        surfaces, centre = part_of(state, "surfaces"), part_of(state, "centre")
        self._centre.check(centre)
        self._surfaces.restore(surfaces, now_us=max(now_us, 0))
        self._centre.restore(centre)
        self._hop, self._now_us = hop, None if now_us < 0 else now_us
        self.maps = self._blank_maps

    def _wake(self, t_us: int) -> None:
        """Start with the hop of this time where it comes late and no event was before."""
        if self._surfaces.is_fresh and t_us > self.config.quiet_limit_us:
            self._begin_hop(t_us // self.config.hop_us)

    def _due(self, t_us: int) -> list[MotionEstimate]:
        """Estimates of the windows that end at or before `t_us`, as far as the fly is awake."""
        estimates = []
        hop_us = self.config.hop_us
        while (end_us := (self._hop + 1) * hop_us) <= t_us:
            if end_us - self._surfaces.last_event_us > self.config.quiet_limit_us:
                self._sleep()
                self._begin_hop(t_us // hop_us)
                break
            estimates.append(self._estimate(end_us))
            self._begin_hop(self._hop + 1)
        return estimates

    def _sleep(self) -> None:
        """Forget everything: a new fly would see no less."""
        self._surfaces.forget()
        self._centre.release()
        self.maps = self._blank_maps

    def _begin_hop(self, hop: int) -> None:
        self._hop = hop
        self._surfaces.begin_hop(hop)

    def _estimate(self, end_us: int) -> MotionEstimate:
        c = self.config
        off, on = self._surfaces.average(hop=self._hop)
        if self._surfaces.is_quiet:
            self._centre.release()
            self.maps = self._blank_maps
        else:
            self.maps = self._see(on, off)
        lp = lobula_plate(self.maps.motion, self.maps.attended)
        response = horizontal_system(lp), vertical_system(lp)
        hs, vs = self._normalise(response, lp)
        snr = signal_to_noise(self.maps.motion, self.maps.attended)
        x, y = self._centre.position
        return MotionEstimate(
            t_us=end_us,
            hs=hs,
            vs=vs,
            direction=winner_take_all(
                hs,
                vs,
                snr=snr,
                snr_floor=c.snr_floor,
                shares=shares_of_total(lp),
                share_floor=c.share_floor,
            ),
            strength=max(abs(hs), abs(vs)),
            response=response,
            view_centre_px=((x + 0.5) * c.cell_px, (y + 0.5) * c.cell_px),
            roi_px=self._roi_px(),
        )

    def _normalise(
        self, response: tuple[float, float], lp: tuple[float, float, float, float]
    ) -> tuple[float, float]:
        if self.config.normalisation is Normalisation.TOTAL:
            return shares_of_total(lp)
        cells, scale = self.maps.attended.size, self.config.response_scale
        hs, vs = (normalise(r, cells=cells, scale=scale) for r in response)
        return hs, vs

    def _see(self, on: F32, off: F32) -> FlyMaps:
        c = self.config
        off_delayed, on_delayed = self._surfaces.delayed(hop=self._hop)
        t4_maps = t4(on, on_delayed, offsets=c.offsets_cells, pair_location=c.pair_location)
        t5_maps = t5(off, off_delayed, offsets=c.offsets_cells, pair_location=c.pair_location)
        motion = t4_maps + t5_maps
        saliency = saliency_map(on, off, radius=c.saliency_radius_cells)
        self._centre.update(saliency, motion)
        attended = self._attend(on, off)
        return FlyMaps(on, off, motion, saliency, attended, c.cell_px)

    def _attend(self, on: F32, off: F32) -> npt.NDArray[np.bool_]:
        """The region of interest."""
        c = self.config
        if not self._centre.is_attending:
            return self._blank_maps.attended
        if c.attention is Attention.EVERYWHERE:
            return np.ones_like(self._blank_maps.attended)
        if c.roi_activity is RegionActivity.BOTH:
            # The delayed arm of a correlation lies behind the present one.
            off_before, on_before = self._surfaces.averaged(hop=self._hop - c.delays_hops[0])
            on, off = on + on_before, off + off_before
        return region_of_interest(
            saliency_map(on, off, radius=c.roi_smoothing_cells),
            self._centre.position,
            reach=c.roi_reach_cells,
            share=c.roi_share,
        )

    def _roi_px(self) -> tuple[int, int, int, int] | None:
        attended, side = self.maps.attended, self.config.cell_px
        rows = np.flatnonzero(attended.any(axis=1))
        if rows.size == 0:
            return None
        columns = np.flatnonzero(attended.any(axis=0))
        x0, y0 = int(columns[0]) * side, int(rows[0]) * side
        x1, y1 = (int(columns[-1]) + 1) * side, (int(rows[-1]) + 1) * side
        return x0, y0, min(x1, self._width), min(y1, self._height)


def _checked(config: Any) -> FlyConfig:
    if not isinstance(config, FlyConfig):
        raise DetectorConfigError(
            f"the configuration is {config!r}; allowed is a FlyConfig; make one with FlyConfig(), "
            'or by name with FlyConfig.preset("wide")'
        )
    return config


def _side(name: str, value: Any) -> int:
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise DetectorConfigError(
            f"{name} is {value!r}; allowed is a whole number of px; pass it as an int"
        )
    return int(value)


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
