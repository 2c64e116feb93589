"""The frame-based fly: the model of Fu and Yue (2020), on APS frames at their own rate."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from detector.errors import DetectorConfigError, FrameError
from detector.estimate import MotionEstimate
from detector.event_checks import check_chunk, check_order, whole_time
from detector.fly.tangential import winner_take_all
from detector.frame_fly.config import FrameFlyConfig
from detector.frame_fly.correlation import (
    block_signal_to_noise,
    block_sums,
    opponent_motion,
    smoothed,
    tangential_response,
)
from detector.frame_fly.pathways import (
    Adaptation,
    blurred,
    gaussian_kernel,
    grey_levels,
    luminance_change,
    on_off,
    spatial_difference,
)
from flybench.events import Events

__all__ = ["FrameFly", "FrameFlyConfig"]

F32 = npt.NDArray[np.float32]


class FrameFly:
    """Direction of motion from frames, as the fly's optic lobe would (Fu and Yue, 2020).

    It is a `FrameDetector`: it gives an estimate at every frame but the first, and listens to
    events only for their time. Every filter follows the interval between frames, whatever it is.

    Operating range: correlators see motion by 2 to 6 cells a frame, and a little beyond where the
    pattern is coarse. That is 80 to 240 px/s at 40 frames a second, 20 to 60 px/s at 10; the preset
    "coarse" has three times as much.
    """

    def __init__(
        self, config: FrameFlyConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 without a frame.

        Args:
            config: parameters; the published ones where None.
            width: sensor columns [px].
            height: sensor rows [px].

        Raises:
            DetectorConfigError: the sensor has no room for one correlation distance.
        """
        self.config = c = config or FrameFlyConfig()
        least = (min(c.offsets_cells) + 1) * c.cell_px
        if min(width, height) < least or max(width, height) > 32_767:
            raise DetectorConfigError(
                f"the sensor is {width}×{height} px; allowed is {least} to 32767 px a side with "
                f"cells of {c.cell_px} px and offsets_cells = {c.offsets_cells}; lower these"
            )
        self._width, self._height = width, height
        grid = height // c.cell_px, width // c.cell_px
        self._centre = gaussian_kernel(c.kernel_centre_cells, c.sigma_centre_cells)
        self._surround = gaussian_kernel(c.kernel_surround_cells, c.sigma_surround_cells)
        self._adaptation = Adaptation(
            (2, *grid), rising_us=c.depolarising_us, falling_us=c.repolarising_us
        )
        self._levels: F32 | None = None
        self._pathways = np.zeros((2, *grid), np.float32)
        self._motion = np.zeros((2, 2, *grid), np.float32)
        self._frame_us = self._now_us = 0

    def push(self, events: Events) -> list[MotionEstimate]:
        """Take the time from the next events; see `Detector.push`. There are no estimates.

        Raises:
            EventError: not a sorted stream of `EVENT_DTYPE` from this sensor.
            EventOrderError: the first event is older than what was passed or advanced to before.
        """
        check_chunk(events, width=self._width, height=self._height, now_us=self._now_us)
        if events.size:
            self._now_us = int(events["t"][-1])
        return []

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Learn that every event before `t_us` was passed; see `Detector.advance`.

        Raises:
            EventOrderError: `t_us` is before what was passed or advanced to before, or is no whole
                number.
        """
        t_us = whole_time(t_us)
        check_order(t_us, self._now_us)
        self._now_us = t_us
        return []

    def push_frame(self, t_us: int, frame: npt.NDArray[np.uint16]) -> list[MotionEstimate]:
        """Take the next frame; see `FrameDetector.push_frame`.

        Raises:
            FrameError: no (height, width) uint16 array.
            EventOrderError: `t_us` is before what was passed before, or is no whole number.
        """
        t_us = whole_time(t_us)
        check_order(t_us, self._now_us)
        self._check_frame(frame)
        c = self.config
        before, interval_us = self._levels, t_us - self._frame_us
        self._levels = grey_levels(frame, full_scale_dn=c.full_scale_dn, cell_px=c.cell_px)
        self._frame_us = self._now_us = t_us
        if before is None:
            return []
        self._see(luminance_change(self._levels, before), interval_us)
        return [self._estimate(t_us)]

    def _check_frame(self, frame: npt.NDArray[np.uint16]) -> None:
        kind = type(frame).__name__
        if isinstance(frame, np.ndarray):
            if frame.dtype == np.uint16 and frame.shape == (self._height, self._width):
                return
            kind = f"{frame.dtype} array of shape {frame.shape}"
        raise FrameError(
            f"the frame is a {kind}; allowed is a uint16 array of shape ({self._height}, "
            f"{self._width}); pass the sensor's raw counts, or make the detector with its size"
        )

    def _see(self, change: F32, interval_us: int) -> None:
        """From a change of luminance to T4 and T5."""
        c = self.config
        lamina = spatial_difference(blurred(change, self._centre), blurred(change, self._surround))
        pathways = self._adaptation.step(on_off(lamina), interval_us=interval_us)
        for n in (0, 1):
            motion = opponent_motion(
                pathways[n],
                self._pathways[n],
                interval_us=interval_us,
                offsets=c.offsets_cells,
                delays_us=c.delays_us,
            )
            self._motion[n] = smoothed(motion, self._motion[n], share=c.smoothing)
        self._pathways = pathways

    def _estimate(self, t_us: int) -> MotionEstimate:
        """Tangential cells: HS and VS from T4 and T5 of the whole field."""
        c = self.config
        grid = self._motion.shape[2:]
        sums = block_sums(self._motion.reshape(4, *grid), side=c.kernel_centre_cells)
        totals = sums.sum(axis=(1, 2)).reshape(2, 2)
        cells = math.prod(grid)
        hs, vs = (
            sum(tangential_response(t, cells=cells, scale=c.response_scale) for t in pathways)
            for pathways in totals.T.tolist()
        )
        snr = block_signal_to_noise(sums[:2] + sums[2:])
        horizontal, vertical = totals.sum(axis=0).tolist()
        return MotionEstimate(
            t_us=t_us,
            hs=hs,
            vs=vs,
            direction=winner_take_all(hs, vs, snr=snr, snr_floor=c.snr_floor),
            strength=max(abs(hs), abs(vs)),
            response=(horizontal, vertical),
            view_centre_px=(self._width / 2, self._height / 2),
            roi_px=None,
        )
