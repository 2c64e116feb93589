"""What `flybench emulate` reads pictures from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy.typing as npt

from scenarios.emulate.frame_times import FrameTimes
from scenarios.errors import ScenarioError

MAX_PIXELS = 4096 * 4096
"""Largest picture [px] (assumed: its conversion to luminance takes half a gigabyte)."""


class Pictures(ABC):
    """A sequence of pictures; iterate over it to read them.

    A picture is (height, width) or (height, width, 3) grey levels as uint8 or uint16, in the order
    red, green, blue, or (height, width) floating-point luminance in cd/m².

    Attributes:
        times: time of each picture.
        are_luminance: True if the pictures are luminance, False if they are grey levels.
    """

    times: FrameTimes
    are_luminance: bool = False

    @abstractmethod
    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        """Yield the pictures, all of one size.

        Raises:
            ScenarioError: a picture is damaged, or its size differs from that of the first.
        """


def check_size(path: Path, width: int, height: int) -> None:
    """Check that a picture is not too large.

    Raises:
        ScenarioError: it has more than `MAX_PIXELS`.
    """
    if width * height > MAX_PIXELS:
        raise ScenarioError(
            f"{path} has {width}x{height} px. Allowed are {MAX_PIXELS:,} pixels in all. Make it "
            "smaller."
        )
