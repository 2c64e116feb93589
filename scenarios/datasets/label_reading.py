"""Labels of one time of a sequence, read from its files."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from scenarios.dataset.labels.png import decode_depth, decode_flow, read_png
from scenarios.dataset.layout import (
    BACKWARD,
    DEPTH,
    FORWARD,
    IMAGES,
    MASKS,
    MOTION,
    TRACKS,
    VELOCITY,
    file_name,
)

DIRECTIONS = (Direction.RIGHT, Direction.LEFT, Direction.UP, Direction.DOWN)
"""Directions in the order of their numbers in the label "direction"."""


@dataclass
class SequenceLabels:
    """The labels of a sequence; small tables stay in memory once they are read.

    Attributes:
        folder: folder of the sequence.
        times_us: times of the labels [µs].
    """

    folder: Path
    times_us: range

    def read(self, name: str, number: int) -> dict[str, Any]:
        """Return the arrays of a label at time number `number`, by name.

        Args:
            name: one of `READABLE`.
            number: number of the label.
        """
        arrays: dict[str, Any] = READABLE[name].read(self, number)
        return arrays

    def _flow(self, number: int) -> dict[str, Any]:
        return self._read_flow(FORWARD, number, "flow")

    def _flow_backward(self, number: int) -> dict[str, Any]:
        return self._read_flow(BACKWARD, number, "flow_backward")

    def _read_flow(self, folder: str, number: int, name: str) -> dict[str, Any]:
        flow, valid = decode_flow(read_png(self.folder / folder / file_name(number)))
        return {name: _channels_first(flow), f"{name}_valid": valid}

    def _velocity(self, number: int) -> dict[str, Any]:
        with h5py.File(self.folder / VELOCITY) as file:
            return {"velocity": _channels_first(file["velocity_px_s"][number])}

    def _depth(self, number: int) -> dict[str, Any]:
        return {"depth": decode_depth(read_png(self.folder / DEPTH / file_name(number)))}

    def _masks(self, number: int) -> dict[str, Any]:
        return {"masks": read_png(self.folder / MASKS / file_name(number))}

    def _images(self, number: int) -> dict[str, Any]:
        return {"images": _channels_first(read_png(self.folder / IMAGES / file_name(number)))}

    def _boxes(self, number: int) -> dict[str, Any]:
        return {"boxes": self._tracks[self._tracks["t"] == self.times_us[number]]}

    def _target_motion(self, number: int) -> dict[str, Any]:
        row = self._motion[number]
        velocity = [float(row[f"image_velocity_{axis}_px_s"]) for axis in "xy"]
        return {
            "direction": DIRECTIONS.index(Direction(row["direction"])),
            "angular_velocity_rad_s": np.float32(row["angular_velocity_rad_s"]),
            "image_velocity_px_s": np.array(velocity, np.float32),
            "visibility": np.float32(row["visibility"]),
        }

    @cached_property
    def _tracks(self) -> npt.NDArray[Any]:
        return np.asarray(np.load(self.folder / TRACKS))

    @cached_property
    def _motion(self) -> list[Mapping[str, str]]:
        """The rows of the target, one for each label."""
        with (self.folder / MOTION).open(newline="", encoding="utf-8") as file:
            return [row for row in csv.DictReader(file) if row["name"] == "target"]


def _channels_first(image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return np.ascontiguousarray(np.moveaxis(image, -1, 0))


@dataclass(frozen=True)
class Readable:
    """A label that samples can have.

    Attributes:
        label: label of the dataset that holds it.
        read: function of the labels of a sequence and a number.
        first: lowest number that has it.
        last: highest number that has it, counted from the end of the sequence: −1 is the last.
    """

    label: str
    read: Callable[[SequenceLabels, int], dict[str, Any]]
    first: int = 0
    last: int = -1


READABLE: dict[str, Readable] = {
    "flow": Readable("flow", SequenceLabels._flow, last=-2),
    "flow_backward": Readable("flow", SequenceLabels._flow_backward, first=1),
    "velocity": Readable("velocity", SequenceLabels._velocity),
    "depth": Readable("depth", SequenceLabels._depth),
    "masks": Readable("masks", SequenceLabels._masks),
    "images": Readable("images", SequenceLabels._images),
    "boxes": Readable("boxes", SequenceLabels._boxes),
    "motion": Readable("motion", SequenceLabels._target_motion),
}
"""Labels that samples can have, by name."""
