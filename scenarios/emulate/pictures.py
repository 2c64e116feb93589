"""Read pictures one at a time from a video, a folder of images or an array."""

from __future__ import annotations

import math
import re
import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from PIL import Image

from scenarios.errors import ScenarioError

IMAGE_ENDINGS = frozenset(
    {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp", ".pgm", ".ppm"}
)
MAX_PIXELS = 4096 * 4096
"""Largest picture [px] (assumed: its conversion to luminance takes half a gigabyte)."""


class Pictures(ABC):
    """A sequence of pictures; iterate over it to read them.

    A picture is (height, width) or (height, width, 3) grey levels as uint8 or uint16, in the order
    red, green, blue, or (height, width) floating-point luminance in cd/m².

    Attributes:
        count: number of pictures that the file states; 0 if it is unknown.
        fps: frames per second that the file states; None if it states none.
    """

    count: int = 0
    fps: float | None = None

    @abstractmethod
    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        """Yield the pictures, all of one size.

        Raises:
            ScenarioError: a picture is damaged, or its size differs from that of the first.
        """


def open_pictures(path: Path) -> Pictures:
    """Open a video, a folder of images (sorted by the numbers in their names) or a .npy array.

    Raises:
        ScenarioError: the pictures cannot be read; the message states why.
    """
    if path.is_dir():
        return _Folder(path)
    if not path.is_file():
        raise ScenarioError(
            f"{path} does not exist. Allowed is a video, a folder of images or a .npy array. Check "
            "its name and folder."
        )
    if path.stat().st_size == 0:
        raise ScenarioError(f"{path} is empty. Copy it again from where it was made.")
    if path.suffix.lower() == ".npy":
        return _Array(path)
    if path.suffix.lower() in IMAGE_ENDINGS:
        raise ScenarioError(
            f"{path} is a single image. Allowed is a folder of images that follow each other. Give "
            "the folder that contains it."
        )
    return _Video(path)


class _Video(Pictures):
    def __init__(self, path: Path) -> None:
        self._path = path
        capture = self._open()
        try:
            self.count = max(0, int(capture.get(cv2.CAP_PROP_FRAME_COUNT)))
            fps = float(capture.get(cv2.CAP_PROP_FPS))
            size = capture.get(cv2.CAP_PROP_FRAME_WIDTH), capture.get(cv2.CAP_PROP_FRAME_HEIGHT)
        finally:
            capture.release()
        _check_size(path, int(size[0]), int(size[1]))
        self.fps = fps if math.isfinite(fps) and fps > 0 else None

    def _open(self) -> Any:
        capture = cv2.VideoCapture(str(self._path), cv2.CAP_FFMPEG)
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


class _Folder(Pictures):
    def __init__(self, path: Path) -> None:
        self._files = sorted(
            (file for file in path.iterdir() if file.suffix.lower() in IMAGE_ENDINGS),
            key=_by_number,
        )
        self.count = len(self._files)
        if not self._files:
            raise ScenarioError(
                f"The folder {path} contains no images. Allowed are the endings "
                f"{', '.join(sorted(IMAGE_ENDINGS))}. Give the folder that contains the images."
            )

    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        shape: tuple[int, ...] | None = None
        for file in self._files:
            image = _read(file)
            shape = shape or image.shape[:2]
            if image.shape[:2] != shape:
                raise ScenarioError(
                    f"{file} has {image.shape[1]}x{image.shape[0]} px, and the first image "
                    f"{shape[1]}x{shape[0]} px. All images must have one size. Resize them."
                )
            yield image


class _Array(Pictures):
    def __init__(self, path: Path) -> None:
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
        _check_size(path, array.shape[2], array.shape[1])
        self.count = len(array)

    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        for image in self._array:
            yield np.ascontiguousarray(image)


def _by_number(file: Path) -> list[tuple[int, int | str]]:
    """Return a sort key by which frame_10 comes after frame_9."""
    parts = re.split(r"(\d+)", file.name)
    return [(1, int(part)) if part.isdigit() else (0, part) for part in parts]


def _check_size(path: Path, width: int, height: int) -> None:
    if width * height > MAX_PIXELS:
        raise ScenarioError(
            f"{path} has {width}x{height} px. Allowed are {MAX_PIXELS:,} pixels in all. Make it "
            "smaller."
        )


def _read(file: Path) -> npt.NDArray[Any]:
    image: Any = None
    with suppress(OSError, cv2.error):
        _check_size(file, *_size(file))
        image = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
    if image is None or image.dtype not in (np.uint8, np.uint16):
        raise ScenarioError(
            f"{file} is not a readable image of 8 or 16 bits. Write it again, or remove it."
        )
    if image.ndim == 2:
        return np.asarray(image)
    return np.ascontiguousarray(image[..., 2::-1] if image.shape[2] >= 3 else image[..., 0])


def _size(file: Path) -> tuple[int, int]:
    """Return width and height from the header of an image, without decoding it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Image.DecompressionBombWarning)
        try:
            with Image.open(file) as header:
                width, height = header.size
        except Image.DecompressionBombError as error:
            raise ScenarioError(
                f"{file} is too large ({error}). Allowed are {MAX_PIXELS:,} pixels in all. Make it "
                "smaller."
            ) from error
    return width, height
