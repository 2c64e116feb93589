"""Frames of a video or of images that were recorded beside the events."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from emulator import ApsFrame, SensorConfig
from emulator.grey_levels import Transfer
from emulator.pixel.optics import lux_per_cd_m2
from flybench.memory import check_memory
from scenarios.calibrate.recording import MAX_FRAMES
from scenarios.emulate.frame_times import TimeOptions
from scenarios.emulate.picture_luminance import sensor_luminance
from scenarios.emulate.pictures import open_pictures

_FULL_SCALE = 1023
"""Level of the highest luminance [DN]."""


@dataclass(frozen=True)
class VideoFrames:
    """Frames in levels of 10 bits, and what a level means.

    Attributes:
        frames: frames of the sensor's size, each exposed for 0 µs.
        lux_per_level: illuminance on the chip for each level [lux/DN].
    """

    frames: tuple[ApsFrame, ...]
    lux_per_level: float


def read_video(
    path: Path,
    sensor: SensorConfig,
    *,
    times: TimeOptions,
    first_us: int,
    white_cd_m2: float,
    transfer: Transfer,
) -> VideoFrames:
    """Read the frames of a video, a folder of images or an array, scaled to fill the sensor.

    Args:
        path: what to read.
        sensor: the sensor, for its size and its lens.
        times: what is known about the times of the frames.
        first_us: time of the first frame on the clock of the events [µs].
        white_cd_m2: luminance of the highest grey level [cd/m²].
        transfer: relation of grey levels to luminance.

    Raises:
        ScenarioError: the pictures cannot be read, or have no valid times.
        FrameError: `white_cd_m2` is out of range.
        MemoryBudgetError: the frames do not fit into the memory budget.
    """
    pictures = open_pictures(path, times)
    number = min(MAX_FRAMES, pictures.times.t_us.size)
    what = f"The list of {number} frames of {path}"
    check_memory(what, number * sensor.width * sensor.height * 2)

    def frames() -> Iterator[ApsFrame]:
        times_us = pictures.times.t_us[:number].tolist()
        for k, (picture, t_us) in enumerate(zip(pictures, times_us, strict=False)):
            luminance = sensor_luminance(
                picture,
                size=(sensor.width, sensor.height),
                white_cd_m2=white_cd_m2,
                transfer=transfer,
                frame=k,
            )
            levels = np.rint(np.clip(luminance / white_cd_m2, 0.0, 1.0) * _FULL_SCALE)
            at_us = first_us + t_us
            yield ApsFrame(at_us, at_us, levels.astype(np.uint16))

    per_cd_m2 = lux_per_cd_m2(f_number=sensor.f_number, transmission=sensor.transmission)
    return VideoFrames(tuple(frames()), white_cd_m2 * per_cd_m2 / _FULL_SCALE)
