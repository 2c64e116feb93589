"""The fly of the paper (Section II), on a stream of events in chunks of any size."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Integral
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.decision import winner_take_all
from detector.errors import DetectorConfigError, StateError
from detector.estimate import MotionEstimate
from detector.event_checks import (
    check_chunk,
    check_estimates,
    check_order,
    check_pause,
    checked_time,
)
from detector.fly.attention import ViewCentre, saliency_map
from detector.fly.config import FlyConfig
from detector.fly.correlation import t4, t5
from detector.fly.maps import FlyMaps
from detector.fly.model_variants import Attention, Normalisation, RegionActivity, SurfaceEvents
from detector.fly.region import region_of_interest
from detector.fly.saturating_surface import SaturatingSurfaces
from detector.fly.state import (
    State,
    check_arrays,
    check_header,
    join_parts,
    part_of,
    state_header,
)
from detector.fly.tangential import (
    DirectionSums,
    LeakyIntegrator,
    horizontal_system,
    lobula_plate,
    normalise,
    shares_of_all,
    shares_of_total,
    signal_to_noise,
    vertical_system,
)
from detector.fly.time_surface import TimeSurfaces
from flybench.events import Events
from flybench.memory import count_memory

__all__ = ["FlyConfig", "FlyDetector", "FlyMaps"]

F32 = npt.NDArray[np.float32]

_MAPS_BYTES = 160
"""Memory for the maps of one estimate, with intermediate results, per cell (measured: 121 to 136)
[bytes]."""


class FlyDetector:
    """Direction of motion from events, modelled on the fly's optic lobe (paper, Section II).

    It returns an estimate at every whole multiple of the hop from time 0.

    Operating range, on synthetic targets of 120 px in four directions: with the paper's parameters,
    steps are right from 160 px/s (measured up to 1500 px/s). Below 160 px/s the response is weak
    and may have the wrong sign, and most estimates are `NONE`. `FlyConfig.preset("wide")` is right
    from 30 to 1500 px/s. Both hold in noise of up to 10 Hz per pixel.

    If there is no event for `quiet_limit_us`, estimates stop, and the fly forgets everything. They
    resume with the hop of the next event, so that a gap of hours costs no more than one of a
    minute. If the first event of a stream is later than that limit, estimates start with its hop,
    and an earlier `advance` beyond the limit returns nothing.

    Attributes:
        config: parameters.
        memory_us: time after which an estimate has seen all that it compares; see
            `FlyConfig.memory_us` [µs].
        maps: maps behind the last estimate.
    """

    def __init__(
        self, config: FlyConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 without a memory, looking at the image centre.

        Args:
            config: parameters; None: those of the paper.
            width: sensor columns [px].
            height: sensor rows [px].

        Raises:
            DetectorConfigError: `config` is not a `FlyConfig`, a side is not a whole number, or the
                sensor is smaller than the shortest correlation distance.
            MemoryBudgetError: the sensor or the number of hops is too large for the memory budget.
        """
        self.config = c = _checked_config(FlyConfig() if config is None else config)
        width, height = _checked_side("width", width), _checked_side("height", height)
        least = (c.spacing_cells + 1) * c.cell_px
        if min(width, height) < least or max(width, height) > 32_767:
            raise DetectorConfigError(
                f"The sensor is {width}×{height} px. Allowed is {least} to 32767 px a side with "
                f"cells of {c.cell_px} px and spacing_cells = {c.spacing_cells}. Lower these."
            )
        check_pause(c.hop_us, c.quiet_limit_us)
        count_memory(self, f"A fly of {width}×{height} px", _needed_bytes(c, width, height))
        self.memory_us = c.memory_us
        self._width, self._height = width, height
        is_saturating = c.time_surface is SurfaceEvents.SATURATING
        kind = SaturatingSurfaces if is_saturating else TimeSurfaces
        self._surfaces: SaturatingSurfaces | TimeSurfaces = kind(c, width=width, height=height)
        grid = self._surfaces.rows, self._surfaces.columns
        left, top = self._surfaces.origin_px
        image_centre = (width / 2 - left) / c.cell_px - 0.5, (height / 2 - top) / c.cell_px - 0.5
        self._centre = ViewCentre(c, grid=grid, image_centre=image_centre)
        self._integrated = LeakyIntegrator(time_constant_us=c.integration_us, hop_us=c.hop_us)
        self._hop = 0
        self._now_us: int | None = None
        self._blank_maps = FlyMaps.blank(grid, cell_px=c.cell_px, origin_px=(left, top))
        self.maps = self._blank_maps

    def push(self, events: Events) -> list[MotionEstimate]:
        """Process the next events of the stream; see `Detector.push`.

        Raises:
            EventError: the chunk is not a sorted stream of `EVENT_DTYPE` from this sensor.
            EventOrderError: the first event is before an event or a time that was passed before.
            MemoryBudgetError: the events of a window, or the estimates of this call, are too many
                for the memory budget. The events before them have been processed.
        """
        c, now_us = self.config, 0 if self._now_us is None else self._now_us
        check_chunk(events, width=self._width, height=self._height, now_us=now_us)
        if events.size == 0:
            return []
        check_estimates(
            events["t"], now_us=now_us, hop_us=c.hop_us, quiet_limit_us=c.quiet_limit_us
        )
        self._skip_to_late_start(int(events["t"][0]))
        estimates: list[MotionEstimate] = []
        taken = 0
        while True:
            hop_end_us = (self._hop + 1) * self.config.hop_us
            taken = self._surfaces.accumulate(events, taken, until_us=hop_end_us)
            if taken == events.size:
                break
            estimates += self._due_estimates(int(events["t"][taken]))
        self._now_us = self._surfaces.last_event_us
        return estimates

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Declare that every event before `t_us` has been passed; see `Detector.advance`.

        Raises:
            EventOrderError: `t_us` is before an event or a time that was passed before, is too
                large, or is not a whole number.
        """
        t_us = checked_time(t_us)
        check_order(t_us, self._now_us or 0)
        self._now_us = t_us
        self._skip_to_late_start(t_us)
        return self._due_estimates(t_us)

    def state(self) -> State:
        """Return the memory of the fly as plain arrays, for `restore`.

        `np.savez(path, **fly.state())` saves it. Its size depends on the number of events in the
        last window and not on the length of the stream. It does not contain the maps for display.
        """
        now_us = -1 if self._now_us is None else self._now_us
        parts = {
            "fly": {"hop": np.array(self._hop), "now_us": np.array(now_us)},
            "surfaces": self._surfaces.state(),
            "centre": self._centre.state(),
            "tangential": self._integrated.state(),
        }
        header = state_header(self.config, width=self._width, height=self._height)
        return header | join_parts(parts)

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Continue from the `state` of another fly; the estimates that follow are equal.

        Raises:
            StateError: the state is of another configuration or sensor, is incomplete, or
                contradicts itself.
        """
        check_header(state, state_header(self.config, width=self._width, height=self._height))
        check_arrays(
            state, self.state(), any_length={"surfaces.times", "surfaces.pixels", "surfaces.merged"}
        )
        hop, now_us = int(state["fly.hop"]), int(state["fly.now_us"])
        if hop != max(now_us, 0) // self.config.hop_us:
            raise StateError(
                f"The state is in hop {hop} at {now_us} µs. Allowed is the hop of that time, "
                f"{max(now_us, 0) // self.config.hop_us}. Pass everything that "
                "FlyDetector.state() returned, unchanged."
            )
        surfaces, centre = part_of(state, "surfaces"), part_of(state, "centre")
        tangential = part_of(state, "tangential")
        self._centre.check(centre)
        self._integrated.check(tangential)
        self._surfaces.restore(surfaces, now_us=max(now_us, 0))
        self._integrated.restore(tangential)
        self._centre.restore(centre)
        self._hop, self._now_us = hop, None if now_us < 0 else now_us
        self.maps = self._blank_maps

    def _skip_to_late_start(self, t_us: int) -> None:
        """Skip to the hop of a late time if there was no event yet."""
        if self._surfaces.is_fresh and t_us > self.config.quiet_limit_us:
            self._begin_hop(t_us // self.config.hop_us)

    def _due_estimates(self, t_us: int) -> list[MotionEstimate]:
        """Return the estimates that end at or before `t_us` and within the quiet limit."""
        estimates = []
        hop_us = self.config.hop_us
        while (end_us := (self._hop + 1) * hop_us) <= t_us:
            if end_us - self._surfaces.last_event_us > self.config.quiet_limit_us:
                self._forget()
                self._begin_hop(t_us // hop_us)
                break
            estimates.append(self._estimate(end_us))
            self._begin_hop(self._hop + 1)
        return estimates

    def _forget(self) -> None:
        """Return to the initial state, as of a new fly."""
        self._surfaces.forget()
        self._integrated.rest()
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
            self.maps = self._compute_maps(on, off)
        lp = self._integrated(lobula_plate(self.maps.motion, self.maps.attended))
        response = horizontal_system(lp), vertical_system(lp)
        hs, vs = self._normalise(response, lp)
        snr = signal_to_noise(self.maps.motion, self.maps.attended)
        (x, y), (left, top) = self._centre.position, self._surfaces.origin_px
        return MotionEstimate(
            t_us=end_us,
            hs=hs,
            vs=vs,
            direction=winner_take_all(
                hs,
                vs,
                snr=snr,
                snr_floor=c.snr_floor,
                shares=self._shares(lp),
                share_floor=c.share_floor,
            ),
            strength=max(abs(hs), abs(vs)),
            response=response,
            view_centre_px=((x + 0.5) * c.cell_px + left, (y + 0.5) * c.cell_px + top),
            roi_px=self.maps.bounding_box_px(width=self._width, height=self._height),
        )

    def _normalise(self, response: tuple[float, float], lp: DirectionSums) -> tuple[float, float]:
        if self.config.normalisation is not Normalisation.CELLS:
            return self._shares(lp)
        cells, scale = self.maps.attended.size, self.config.response_scale
        hs, vs = (normalise(r, cells=cells, scale=scale) for r in response)
        return hs, vs

    def _shares(self, lp: DirectionSums) -> tuple[float, float]:
        """Return HS and VS relative to the responses that the normalisation divides by."""
        is_all = self.config.normalisation is Normalisation.ALL
        return shares_of_all(lp) if is_all else shares_of_total(lp)

    def _compute_maps(self, on: F32, off: F32) -> FlyMaps:
        c = self.config
        off_delayed, on_delayed = self._surfaces.delayed(hop=self._hop)
        pairs: dict[str, Any] = {
            "offsets": c.offsets_cells,
            "pair_location": c.pair_location,
            "receptive_fields": c.receptive_fields,
        }
        motion = t4(on, on_delayed, **pairs) + t5(off, off_delayed, **pairs)
        saliency = saliency_map(on, off, radius=c.saliency_radius_cells)
        self._centre.update(saliency, motion, activity=self._surfaces.activity)
        attended = self._attended_region(on, off)
        origin_px = self._surfaces.origin_px
        return FlyMaps(on, off, motion, saliency, attended, c.cell_px, origin_px)

    def _attended_region(self, on: F32, off: F32) -> npt.NDArray[np.bool_]:
        c = self.config
        if not self._centre.is_attending:
            return self._blank_maps.attended
        if c.attention is Attention.EVERYWHERE:
            return np.ones_like(self._blank_maps.attended)
        if c.roi_activity is RegionActivity.BOTH:
            # The delayed point of a correlated pair lies behind the present one.
            off_before, on_before = self._surfaces.averaged(hop=self._hop - c.delays_hops[0])
            on, off = on + on_before, off + off_before
        return region_of_interest(
            saliency_map(on, off, radius=c.roi_smoothing_cells),
            self._centre.position,
            reach=c.roi_reach_cells,
            share=c.roi_share,
        )


def _needed_bytes(config: FlyConfig, width: int, height: int) -> int:
    """Return the memory of a fly without its events [bytes]."""
    cells = -(-width // config.cell_px) * -(-height // config.cell_px)
    hops = 32 * config.window_hops + 8 * (max(config.delays_hops) + 1)
    pixel = 42 if config.time_surface is SurfaceEvents.SATURATING else 16
    return pixel * width * height + cells * (hops + _MAPS_BYTES)


def _checked_config(config: Any) -> FlyConfig:
    if not isinstance(config, FlyConfig):
        raise DetectorConfigError(
            f"The configuration is {config!r}. Allowed is a FlyConfig. Make one with FlyConfig(), "
            'or by name with FlyConfig.preset("wide").'
        )
    return config


def _checked_side(name: str, value: Any) -> int:
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise DetectorConfigError(
            f"{name} is {value!r}. Allowed is a whole number of px. Pass it as an int."
        )
    return int(value)
