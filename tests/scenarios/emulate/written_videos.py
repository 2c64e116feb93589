"""Videos with any time stamps, written with OpenCV alone."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np


def write_video(
    path: Path, ticks: Sequence[int], *, per_s: int, levels: Sequence[int] | None = None
) -> None:
    """Write one grey frame at each time [1/`per_s` s], by default each brighter than the last.

    Each frame is JPEG. In .mov the time stamps are exact, in .mkv they are rounded to 1 ms.
    """
    writer = cv2.VideoWriter(
        str(path),
        cv2.CAP_FFMPEG,
        cv2.VideoWriter.fourcc(*("jpeg" if path.suffix == ".mov" else "MJPG")),
        float(per_s),
        (64, 48),
        [cv2.VIDEOWRITER_PROP_RAW_VIDEO, 1],
    )
    assert writer.isOpened()
    for k, tick in enumerate(ticks):
        level = levels[k] if levels else 4 * k % 256
        _, jpeg = cv2.imencode(".jpg", np.full((48, 64, 3), level, np.uint8))
        writer.set(cv2.VIDEOWRITER_PROP_PTS, tick)
        writer.set(cv2.VIDEOWRITER_PROP_KEY_FLAG, 1)
        writer.write(jpeg)
    writer.release()


def fast_then_slow(frames: int = 60) -> list[int]:
    """Return times of frames at 60 Hz, and from the middle on at 15 Hz [1/60 s]."""
    half = frames // 2
    return [*range(half), *range(half, half + 4 * half, 4)]
