"""Read the frames of a video."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from scenarios.emulate.frame_times import FrameTimes, TimeOptions, evenly_spaced
from scenarios.emulate.picture_source import Pictures, check_size
from scenarios.emulate.time_file import times_of_frames
from scenarios.emulate.video_times import cut_warnings, video_times
from scenarios.errors import ScenarioError

_CONTAINERS = (
    "mov,mp4,m4a,3gp,3g2,mj2,avi,matroska,webm,mpeg,mpegts,ogg,flv,asf,mxf,nut,gif,"
    "yuv4mpegpipe,h264,hevc,m4v,mjpeg,mpegvideo,ivf,obu,dv"
)
"""Formats of FFmpeg that contain the video. Playlists are not among them: they name other files."""


class Video(Pictures):
    """The frames of a video, rotated as its metadata state."""

    def __init__(self, path: Path, options: TimeOptions) -> None:
        """Read the times of all frames.

        Raises:
            ScenarioError: the video cannot be read, or has no times.
        """
        self._path = path
        capture = self._open()
        try:
            stated_count = max(0, int(capture.get(cv2.CAP_PROP_FRAME_COUNT)))
            fps = float(capture.get(cv2.CAP_PROP_FPS))
            size = capture.get(cv2.CAP_PROP_FRAME_WIDTH), capture.get(cv2.CAP_PROP_FRAME_HEIGHT)
            check_size(path, int(size[0]), int(size[1]))
            stamps_ms, start_frames = _time_stamps(capture)
        finally:
            capture.release()
        stated_fps = fps if math.isfinite(fps) and fps > 0 else None
        start_s = max(0.0, start_frames / stated_fps) if stated_fps else 0.0
        cut = cut_warnings(path, stamps_ms, fps=stated_fps, count=stated_count, start_s=start_s)
        times = self._times(stamps_ms, stated_fps, options)
        self.times = replace(times, warnings=(*times.warnings, *cut))

    def _times(
        self, stamps_ms: npt.NDArray[np.float64], fps: float | None, options: TimeOptions
    ) -> FrameTimes:
        if options.fps is not None:
            return evenly_spaced(stamps_ms.size, options.fps, "evenly spaced (--fps)")
        if options.file is not None:
            return times_of_frames(options.file, stamps_ms.size, options.unit)
        return video_times(self._path, stamps_ms, fps)

    def _open(self) -> Any:
        # FFmpeg takes "12:30.mp4" for an address of the protocol "12"; a path from / is a file
        os.environ["OPENCV_FFMPEG_CAPTURE_OPTIONS"] = f"format_whitelist;{_CONTAINERS}"
        capture = cv2.VideoCapture(str(self._path.absolute()), cv2.CAP_FFMPEG)
        if not capture.isOpened():
            capture.release()
            raise ScenarioError(
                f"{self._path} is not a video that OpenCV can open. Allowed is a video that FFmpeg "
                "reads, such as .mp4 or .avi, a folder of images or a .npy array. Convert it, or "
                "copy it again if it is truncated."
            )
        return capture

    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        capture = self._open()
        try:
            while True:
                success, image = capture.read()
                if not success:
                    return
                yield np.ascontiguousarray(image[..., ::-1] if image.ndim == 3 else image)
        finally:
            capture.release()


def _time_stamps(capture: Any) -> tuple[npt.NDArray[np.float64], float]:
    """Return the time stamp of each frame [ms], and the time of the first frame in the file.

    The latter is in frames of the stated rate. All frames are decoded, but none is converted.
    """
    stamps_ms: list[float] = []
    start_frames = 0.0
    while capture.grab():
        start_frames = start_frames if stamps_ms else float(capture.get(cv2.CAP_PROP_PTS))
        stamps_ms.append(float(capture.get(cv2.CAP_PROP_POS_MSEC)))
    return np.array(stamps_ms, np.float64), start_frames
