"""The frame-based fly: the model of Fu and Yue (2020), on APS frames at any rate."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from detector.decision import winner_take_all
from detector.errors import DetectorConfigError, FrameError
from detector.estimate import MotionEstimate
from detector.event_checks import check_chunk, check_order, checked_time
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
from flybench.memory import count_memory

__all__ = ["FrameFly", "FrameFlyConfig"]

F32 = npt.NDArray[np.float32]

_BYTES_PER_PX = 100
"""Memory per pixel with cells of 1 px (measured: 92; larger cells need less) [bytes]."""


class FrameFly:
    """Direction of motion from frames, modelled on the fly's optic lobe (Fu and Yue, 2020).

    It is a `FrameDetector`: it returns an estimate at every frame but the first, and uses only the
    times of events. Its filters adapt to the interval between frames.

    Operating range: the correlators respond to motion by 2 to 6 cells a frame, and by a little more
    if the pattern is coarse. That is 80 to 240 px/s at 40 frames per second, and 20 to 60 px/s at
    10. With the preset "coarse", speeds are three times as high.

    Attributes:
        config: parameters.
        memory_us: longest time constant of the delays [µs].
    """

    def __init__(
        self, config: FrameFlyConfig | None = None, *, width: int = 346, height: int = 260
    ) -> None:
        """Start at time 0 without a frame.

        Args:
            config: parameters; None: the published ones.
            width: sensor columns [px].
            height: sensor rows [px].

        Raises:
            DetectorConfigError: the sensor is smaller than the shortest correlation distance.
            MemoryBudgetError: the sensor is too large for the memory budget.
        """
        self.config = c = config or FrameFlyConfig()
        least = (min(c.offsets_cells) + 1) * c.cell_px
        if min(width, height) < least or max(width, height) > 32_767:
            raise DetectorConfigError(
                f"The sensor is {width}×{height} px. Allowed is {least} to 32767 px a side with "
                f"cells of {c.cell_px} px and offsets_cells = {c.offsets_cells}. Lower these."
            )
        needed = _BYTES_PER_PX * width * height
        count_memory(self, f"A frame-based fly of {width}×{height} px", needed)
        self.memory_us = max(c.delays_us)
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
        """Note the time of the next events and return no estimates; see `Detector.push`.

        Raises:
            EventError: the chunk is not a sorted stream of `EVENT_DTYPE` from this sensor.
            EventOrderError: the first event is before an event or a time that was passed before.
        """
        check_chunk(events, width=self._width, height=self._height, now_us=self._now_us)
        if events.size:
            self._now_us = int(events["t"][-1])
        return []

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Declare that every event before `t_us` has been passed; see `Detector.advance`.

        Raises:
            EventOrderError: `t_us` is before an event or a time that was passed before, or is not a
                whole number.
        """
        t_us = checked_time(t_us)
        check_order(t_us, self._now_us)
        self._now_us = t_us
        return []

    def push_frame(self, t_us: int, frame: npt.NDArray[np.uint16]) -> list[MotionEstimate]:
        """Process the next frame; see `FrameDetector.push_frame`.

        Raises:
            FrameError: the frame is not a (height, width) uint16 array.
            EventOrderError: `t_us` is before an event or a time that was passed before, or is not a
                whole number.
        """
        t_us = checked_time(t_us)
        check_order(t_us, self._now_us)
        self._check_frame(frame)
        c = self.config
        before, interval_us = self._levels, t_us - self._frame_us
        self._levels = grey_levels(frame, full_scale_dn=c.full_scale_dn, cell_px=c.cell_px)
        self._frame_us = self._now_us = t_us
        if before is None:
            return []
        self._update_motion(luminance_change(self._levels, before), interval_us)
        return [self._estimate(t_us)]

    def _check_frame(self, frame: npt.NDArray[np.uint16]) -> None:
        kind = type(frame).__name__
        if isinstance(frame, np.ndarray):
            if frame.dtype == np.uint16 and frame.shape == (self._height, self._width):
                return
            kind = f"{frame.dtype} and shape {frame.shape}"
        raise FrameError(
            f"The frame is of type {kind}. Allowed is a uint16 array of shape ({self._height}, "
            f"{self._width}). Pass the raw counts of the sensor, or make a detector of its size."
        )

    def _update_motion(self, change: F32, interval_us: int) -> None:
        """Compute T4 and T5 from a change of luminance."""
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
            self._motion[n] = smoothed(motion, self._motion[n], weight=c.smoothing)
        self._pathways = pathways

    def _estimate(self, t_us: int) -> MotionEstimate:
        """Compute HS and VS from T4 and T5 of the whole field."""
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
