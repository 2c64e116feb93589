"""Convert pictures to the luminance samples that the sensor takes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from emulator.grey_levels import Transfer
from scenarios.emulate.motion import MotionMeter, interpolated, interpolation_count
from scenarios.emulate.picture_luminance import F32, sensor_luminance
from scenarios.emulate.picture_source import Pictures
from sim.motion.sample_times import MIN_STEP_US

ACCURATE_PX = 1.0
"""Motion between frames above which events are early or late by up to a frame [px]; see
`scenarios.emulate.motion`."""
STEP_PX = 0.5
"""Largest motion between samples with interpolation [px], as in the simulation."""


@dataclass
class MotionStatistics:
    """Statistics of the motion between consecutive frames.

    Attributes:
        pairs: number of pairs of consecutive frames.
        inaccurate: number of pairs with a motion above `ACCURATE_PX`.
        max_px: largest motion [px].
        max_px_s: largest speed of those pairs, 0 if there are none [px/s].
        max_error_us: longest interval of those pairs [µs].
        interpolated: number of interpolated frames.
    """

    pairs: int = 0
    inaccurate: int = 0
    max_px: float = 0.0
    max_px_s: float = 0.0
    max_error_us: int = 0
    interpolated: int = 0

    def add(self, motion_px: float, interval_us: int) -> None:
        """Include a pair of frames."""
        self.pairs += 1
        self.max_px = max(self.max_px, motion_px)
        if motion_px > ACCURATE_PX:
            self.inaccurate += 1
            self.max_px_s = max(self.max_px_s, motion_px / interval_us * 1e6)
            self.max_error_us = max(self.max_error_us, interval_us)


@dataclass(frozen=True, eq=False)
class LuminanceSample:
    """Luminance on the sensor at one time.

    Attributes:
        t_us: time since the first frame [µs].
        luminance: (rows, columns) float32 luminance [cd/m²].
        frame: number of the last frame that was read for it, counted from 0.
    """

    t_us: int
    luminance: F32
    frame: int


def luminance_samples(
    pictures: Pictures,
    *,
    size: tuple[int, int],
    white_cd_m2: float,
    transfer: Transfer,
    interpolate: bool,
    motion: MotionStatistics,
) -> Iterator[LuminanceSample]:
    """Yield the luminance on the sensor at every frame and, if interpolated, between frames.

    Args:
        pictures: the frames and their times.
        size: columns and rows of the sensor [px].
        white_cd_m2: luminance of the highest grey level [cd/m²].
        transfer: relation of grey levels to luminance.
        interpolate: True to interpolate frames so that nothing moves more than `STEP_PX` at once.
        motion: statistics to update.

    Yields:
        Samples in order of time.

    Raises:
        ScenarioError: a picture is damaged, or has an invalid luminance.
        FrameError: `white_cd_m2` is out of range.
    """
    meter = MotionMeter(None if pictures.are_luminance else white_cd_m2)
    before: F32 | None = None
    last_us = 0
    times_us = pictures.times.t_us.tolist()
    for frame, (picture, t_us) in enumerate(zip(pictures, times_us, strict=False)):
        luminance = sensor_luminance(
            picture, size=size, white_cd_m2=white_cd_m2, transfer=transfer, frame=frame
        )
        if before is not None:
            forward_px = meter.flow_px(before, luminance)
            motion_px = meter.motion_px(before, luminance, forward_px)
            motion.add(motion_px, t_us - last_us)
            limit = max(0, (t_us - last_us) // MIN_STEP_US - 1)
            count = min(limit, interpolation_count(motion_px, STEP_PX)) if interpolate else 0
            backward_px = meter.flow_px(luminance, before) if count else forward_px
            for share, mixed in interpolated(before, luminance, forward_px, backward_px, count):
                motion.interpolated += 1
                yield LuminanceSample(round(last_us + share * (t_us - last_us)), mixed, frame)
        yield LuminanceSample(t_us, luminance, frame)
        before, last_us = luminance, t_us
