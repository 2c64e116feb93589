"""From pictures to the samples of light that the sensor sees."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from emulator.grey_levels import Transfer
from scenarios.emulate.fitting import F32, light_on
from scenarios.emulate.motion import MotionMeter, between, pictures_between
from scenarios.emulate.pictures import Pictures
from sim.motion.sample_times import MIN_STEP_US

BELIEVABLE_PX = 1.0
"""Farther than a pixel from frame to frame, and events come too early or too late by up to a frame:
see `scenarios.emulate.motion`."""
STEP_PX = 0.5
"""The farthest that interpolation lets anything move at once, as in the simulation."""


@dataclass
class Motion:
    """What was found of the motion between frames.

    Attributes:
        pairs: frames that were compared with the one before.
        too_far: of these, with a motion above `BELIEVABLE_PX`.
        most_px: the largest motion [px].
        made: pictures that were put between.
    """

    pairs: int = 0
    too_far: int = 0
    most_px: float = 0.0
    made: int = 0

    def add(self, motion_px: float) -> None:
        """Count a pair of frames."""
        self.pairs += 1
        self.too_far += motion_px > BELIEVABLE_PX
        self.most_px = max(self.most_px, motion_px)


@dataclass(frozen=True, eq=False)
class LightSample:
    """Light at a time.

    Attributes:
        t_us: since the first frame [µs].
        luminance: (rows, columns) float32 [cd/m²].
        frame: number of the last frame that it is made of.
    """

    t_us: int
    luminance: F32
    frame: int


def samples(
    pictures: Pictures,
    *,
    fps: float,
    size: tuple[int, int],
    white_cd_m2: float,
    transfer: Transfer,
    interpolate: bool,
    motion: Motion,
) -> Iterator[LightSample]:
    """Light on the sensor at every frame, and between frames where that is asked for.

    Args:
        pictures: what is seen.
        fps: frames a second.
        size: columns and rows of the sensor [px].
        white_cd_m2: luminance of the highest level [cd/m²].
        transfer: how levels stand for light.
        interpolate: whether to put pictures between frames, so that nothing moves farther than
            `STEP_PX` at once.
        motion: takes what is found of the motion.

    Yields:
        Samples in order of time.

    Raises:
        ScenarioError: a picture is damaged, or its light is no light.
        FrameError: the white is out of range.
    """
    meter, before = MotionMeter(white_cd_m2), None
    for frame, picture in enumerate(pictures):
        light = light_on(
            picture, size=size, white_cd_m2=white_cd_m2, transfer=transfer, frame=frame
        )
        t_us = round(frame * 1e6 / fps)
        if before is not None:
            last_us = round((frame - 1) * 1e6 / fps)
            forth_px = meter.flow_px(before, light)
            motion_px = meter.motion_px(before, light, forth_px)
            motion.add(motion_px)
            most = max(0, (t_us - last_us) // MIN_STEP_US - 1)
            number = min(most, pictures_between(motion_px, STEP_PX)) if interpolate else 0
            back_px = meter.flow_px(light, before) if number else forth_px
            for share, mixed in between(before, light, forth_px, back_px, number):
                motion.made += 1
                yield LightSample(round(last_us + share * (t_us - last_us)), mixed, frame)
        yield LightSample(t_us, light, frame)
        before = light
