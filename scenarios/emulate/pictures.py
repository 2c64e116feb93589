"""Pictures to be seen: a video, a folder of images or an array, one frame at a time."""

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

IMAGES = frozenset({".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp", ".pgm", ".ppm"})
PIXELS_MAX = 4096 * 4096
"""Largest picture that is taken (assumed: half a gigabyte while it is turned into light)."""


class Pictures(ABC):
    """A sequence of pictures; iterate over it for them.

    Each is (height, width) or (height, width, 3) in red, green, blue, uint8 or uint16 levels, or
    floating point light in cd/m².

    Attributes:
        count: how many there should be; 0 where nobody knows.
        fps: pictures a second, where the file says so.
    """

    count: int = 0
    fps: float | None = None

    @abstractmethod
    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        """The pictures, all of one size.

        Raises:
            ScenarioError: one is damaged, or of another size than the first.
        """


def open_pictures(path: Path) -> Pictures:
    """A video file, a folder of images in the order of their numbers, or a .npy array.

    Raises:
        ScenarioError: there are none, and why.
    """
    if path.is_dir():
        return _Folder(path)
    if not path.is_file():
        raise ScenarioError(
            f"{path} does not exist; allowed is a video, a folder of images or a .npy array; "
            "check its name and folder"
        )
    if path.stat().st_size == 0:
        raise ScenarioError(f"{path} is empty; copy it again from where it was made")
    if path.suffix.lower() == ".npy":
        return _Array(path)
    if path.suffix.lower() in IMAGES:
        raise ScenarioError(
            f"{path} is one image, in which nothing moves; give the folder that holds it and those "
            "that follow"
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
                f"{self._path} is no video that OpenCV can open; allowed is one of FFmpeg's, such "
                "as .mp4 or .avi, a folder of images or a .npy array; convert it, or copy it again "
                "if it is cut"
            )
        return capture

    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        capture = self._open()
        try:
            while True:
                there, image = capture.read()
                if not there:
                    return
                yield np.ascontiguousarray(image[..., ::-1] if image.ndim == 3 else image)
        finally:
            capture.release()


class _Folder(Pictures):
    def __init__(self, path: Path) -> None:
        self._files = sorted(
            (file for file in path.iterdir() if file.suffix.lower() in IMAGES), key=_by_number
        )
        self.count = len(self._files)
        if not self._files:
            raise ScenarioError(
                f"the folder {path} holds no image; allowed is {', '.join(sorted(IMAGES))}; name "
                "the folder that does"
            )

    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        shape: tuple[int, ...] | None = None
        for file in self._files:
            image = _read(file)
            shape = shape or image.shape[:2]
            if image.shape[:2] != shape:
                raise ScenarioError(
                    f"{file} has {image.shape[1]}x{image.shape[0]} px, and the first image "
                    f"{shape[1]}x{shape[0]}; allowed is one size; bring them to one"
                )
            yield image


class _Array(Pictures):
    def __init__(self, path: Path) -> None:
        try:
            self._array = np.load(path, mmap_mode="r", allow_pickle=False)
        except (ValueError, OSError, EOFError) as error:
            raise ScenarioError(
                f"{path} cannot be read as an array ({error}); write it with numpy.save"
            ) from error
        array = self._array
        grey_or_colour = array.ndim == 3 or (array.ndim == 4 and array.shape[3] == 3)
        known = array.dtype in (np.uint8, np.uint16) or array.dtype.kind == "f"
        light = array.dtype.kind != "f" or array.ndim == 3
        if not (grey_or_colour and known and light and min(array.shape) > 0):
            raise ScenarioError(
                f"{path} holds {array.dtype} of shape {array.shape}; allowed is (frames, height, "
                "width) or (frames, height, width, 3) of uint8 or uint16, or (frames, height, "
                "width) of floating point light in cd/m²; convert it"
            )
        _check_size(path, array.shape[2], array.shape[1])
        self.count = len(array)

    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        for image in self._array:
            yield np.ascontiguousarray(image)


def _by_number(file: Path) -> list[tuple[int, int | str]]:
    """A key by which frame_10 comes after frame_9."""
    parts = re.split(r"(\d+)", file.name)
    return [(1, int(part)) if part.isdigit() else (0, part) for part in parts]


def _check_size(path: Path, width: int, height: int) -> None:
    if width * height > PIXELS_MAX:
        raise ScenarioError(
            f"{path} has {width}x{height} px; allowed is {PIXELS_MAX:,} in all; make it smaller"
        )


def _read(file: Path) -> npt.NDArray[Any]:
    image: Any = None
    with suppress(OSError, cv2.error):
        _check_size(file, *_size(file))
        image = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
    if image is None or image.dtype not in (np.uint8, np.uint16):
        raise ScenarioError(
            f"{file} is no image of 8 or 16 bits that can be read; write it again, or leave it out"
        )
    if image.ndim == 2:
        return np.asarray(image)
    return np.ascontiguousarray(image[..., 2::-1] if image.shape[2] >= 3 else image[..., 0])


def _size(file: Path) -> tuple[int, int]:
    """Width and height that an image's header promises, before memory is taken for it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Image.DecompressionBombWarning)
        try:
            with Image.open(file) as header:
                width, height = header.size
        except Image.DecompressionBombError as error:
            raise ScenarioError(
                f"{file} is too large ({error}); allowed is {PIXELS_MAX:,} pixels; make it smaller"
            ) from error
    return width, height
