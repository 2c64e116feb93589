"""Read a folder of images, with the times that come with it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy.typing as npt

from scenarios.emulate.frame_times import FrameTimes, TimeOptions, evenly_spaced, own_times
from scenarios.emulate.image_file import IMAGE_ENDINGS, read_image
from scenarios.emulate.image_names import in_order, numbers_in_names
from scenarios.emulate.picture_source import Pictures
from scenarios.emulate.time_file import TimeTable, read_time_file, table_times
from scenarios.emulate.time_unit import guess_unit, in_us
from scenarios.errors import ScenarioError

TIME_FILES = (
    "timestamps.txt",  # rpg_vid2e, DSEC, KITTI raw
    "timestamp.txt",  # HS-ERGB, BS-ERGB
    "times.txt",  # KITTI odometry
    "images.txt",  # Event Camera Dataset
    "images.csv",  # ESIM
    "image_timestamps.txt",
    "image_timestamps_left.txt",  # TUM-VIE
    "image_timestamps_right.txt",
    "rgb.txt",  # TUM RGB-D
    "data.csv",  # EuRoC
)
"""Names of text files with times, in order of preference, and data sets that have them. They lie in
the folder of the images or up to two folders above it."""


class ImageFolder(Pictures):
    """The images of a folder, in the order of their times or of the numbers in their names."""

    def __init__(self, path: Path, options: TimeOptions) -> None:
        """Find the images and their times.

        Raises:
            ScenarioError: no images, or no valid times.
        """
        found = [file for file in path.iterdir() if file.suffix.lower() in IMAGE_ENDINGS]
        if not found:
            raise ScenarioError(
                f"The folder {path} contains no images. Allowed are the endings "
                f"{', '.join(sorted(IMAGE_ENDINGS))}. Give the folder that contains the images."
            )
        self._path, self._files = path, in_order(found)
        self.times = self._times(options)

    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        shape: tuple[int, ...] | None = None
        for file in self._files:
            image = read_image(file)
            shape = shape or image.shape[:2]
            if image.shape[:2] != shape:
                raise ScenarioError(
                    f"{file} has {image.shape[1]}x{image.shape[0]} px, and the first image "
                    f"{shape[1]}x{shape[0]} px. All images must have one size. Resize them."
                )
            yield image

    def _times(self, options: TimeOptions) -> FrameTimes:
        if options.fps is not None:
            return evenly_spaced(len(self._files), options.fps, "evenly spaced (--fps)")
        if options.file is not None:
            return self._table_times(options.file, options)
        unused = []
        for place in (self._path, self._path.parent, self._path.parent.parent):
            for file in (place / name for name in TIME_FILES if (place / name).is_file()):
                try:
                    times = self._table_times(file, options)
                except ScenarioError as error:
                    if place == self._path:
                        raise
                    unused.append(f"{file} is not used for the times of the images. {error}")
                else:
                    return replace(times, warnings=(*times.warnings, *unused))
        return replace(self._name_times(options), warnings=tuple(unused))

    def _table_times(self, file: Path, options: TimeOptions) -> FrameTimes:
        table = read_time_file(file)
        if table.names:
            table = self._for_images(file, table)
        elif len(table.values) != len(self._files):
            raise ScenarioError(
                f"{file} has {len(table.values)} times for {len(self._files)} images. There must "
                "be one time for each image. Correct it, or give --times FILE or --fps."
            )
        return table_times(file, table, [image.name for image in self._files], options.unit)

    def _for_images(self, file: Path, table: TimeTable) -> TimeTable:
        """Sort the images by the times of their names, and return only those times.

        A path that exists from the folder of the file names this image alone. Otherwise the name
        without folders counts, because many data sets were moved.
        """
        value_of: dict[str, Fraction] = {}
        for name, value in zip(table.names, table.values, strict=True):
            listed = file.parent / name
            exists = os.path.exists(listed)  # noqa: PTH110  (no error for a name that is too long)
            if exists and not listed.parent.samefile(self._path):
                continue  # it is an image of another folder
            if listed.name in value_of:
                raise ScenarioError(
                    f"{file} names {listed.name} twice. Allowed is one time for each image. "
                    "Remove a line, or give --times FILE or --fps."
                )
            value_of[listed.name] = value
        missing = [image.name for image in self._files if image.name not in value_of]
        if missing:
            raise ScenarioError(
                f"{file} has no time for {missing[0]} and {len(missing) - 1} others of "
                f"{len(self._files)} images. Correct it, or give --times FILE or --fps."
            )
        self._files.sort(key=lambda image: value_of[image.name])
        return replace(table, values=[value_of[image.name] for image in self._files])

    def _name_times(self, options: TimeOptions) -> FrameTimes:
        numbers = numbers_in_names(self._files)
        guessed = guess_unit(numbers, in_names=True) if numbers and len(numbers) > 1 else None
        if options.unit is not None and numbers:
            guessed = options.unit, "--time-unit"
        if guessed is None or not numbers:
            raise ScenarioError(
                f"{self._path} does not state its frames per second: the names of its images "
                f"contain frame numbers or none, and none of {TIME_FILES[0]}, {TIME_FILES[3]} and "
                "similar files gives their times. Give them with --fps, such as --fps 1000, or "
                "with --times FILE, or give --time-unit if the names contain times."
            )
        unit, reason = guessed
        times_us = in_us(numbers, unit)
        names = [file.name for file in self._files]
        return own_times(times_us, names, f"names of the images, in {unit} ({reason})")
