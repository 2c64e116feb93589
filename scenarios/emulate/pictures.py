"""Open a video, a folder of images or an array."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from formats import FormatError, identify_format
from scenarios.emulate.frame_times import FrameTimes, TimeOptions, evenly_spaced
from scenarios.emulate.image_file import IMAGE_ENDINGS
from scenarios.emulate.image_folder import ImageFolder
from scenarios.emulate.picture_source import Pictures, check_size
from scenarios.emulate.time_file import times_of_frames
from scenarios.emulate.video import Video
from scenarios.errors import ScenarioError

_OWN_TIMES = TimeOptions()


def open_pictures(path: Path, options: TimeOptions = _OWN_TIMES) -> Pictures:
    """Open a video, a folder of images or a .npy array, and find the time of each picture.

    Args:
        path: what to open.
        options: what is known about the times. By default, a video is timed by its time stamps, and
            images by a text file or by their names.

    Raises:
        ScenarioError: the pictures cannot be read, or have no valid times; the message states why.
    """
    if options.fps is not None and (options.file or options.unit):
        raise ScenarioError(
            "--fps sets the times of all frames, so --times and --time-unit have no effect. Give "
            "either --fps or them."
        )
    if path.is_dir():
        return ImageFolder(path, options)
    _check_file(path)
    if options.unit is not None and options.file is None:
        raise ScenarioError(
            f"--time-unit has no effect on {path}. It is the unit of times in a text file or in "
            "the names of images. Leave it out, or give --times FILE."
        )
    return _Array(path, options) if path.suffix.lower() == ".npy" else Video(path, options)


def _check_file(path: Path) -> None:
    if not path.is_file():
        raise ScenarioError(
            f"{path} does not exist. Allowed is a video, a folder of images or a .npy array. Check "
            "its name and folder."
        )
    if path.stat().st_size == 0:
        raise ScenarioError(f"{path} is empty. Copy it again from where it was made.")
    if _holds_events(path):
        raise ScenarioError(
            f"{path} is a recording of events, not a video. Detect motion in it with flybench "
            "detect."
        )
    if path.suffix.lower() in IMAGE_ENDINGS:
        raise ScenarioError(
            f"{path} is a single image. Allowed is a folder of images that follow each other. Give "
            "the folder that contains it."
        )


def _holds_events(path: Path) -> bool:
    try:
        return identify_format(path) not in ("npy", "text")
    except FormatError:
        return False


class _Array(Pictures):
    def __init__(self, path: Path, options: TimeOptions) -> None:
        try:
            self._array = np.load(path, mmap_mode="r", allow_pickle=False)
        except (ValueError, OSError, EOFError) as error:
            raise ScenarioError(
                f"{path} cannot be read as an array ({error}). Write it with numpy.save."
            ) from error
        array = self._array
        grey_or_colour = array.ndim == 3 or (array.ndim == 4 and array.shape[3] == 3)
        known_dtype = array.dtype in (np.uint8, np.uint16) or array.dtype.kind == "f"
        valid_luminance = array.dtype.kind != "f" or array.ndim == 3
        valid = grey_or_colour and known_dtype and valid_luminance and min(array.shape) > 0
        if not valid:
            raise ScenarioError(
                f"{path} contains {array.dtype} of shape {array.shape}. Allowed is (frames, "
                "height, width) or (frames, height, width, 3) of uint8 or uint16, or (frames, "
                "height, width) of floating-point luminance in cd/m². Convert it."
            )
        check_size(path, array.shape[2], array.shape[1])
        self.are_luminance = array.dtype.kind == "f"
        self.times = self._times(path, options)

    def _times(self, path: Path, options: TimeOptions) -> FrameTimes:
        if options.file is not None:
            return times_of_frames(options.file, len(self._array), options.unit)
        if options.fps is None:
            raise ScenarioError(
                f"{path} does not state its frames per second. Give them with --fps, such as "
                "--fps 1000, or with --times FILE."
            )
        return evenly_spaced(len(self._array), options.fps, "evenly spaced (--fps)")

    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        for image in self._array:
            yield np.ascontiguousarray(image)
