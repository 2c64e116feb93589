"""The size of the sensor that a recording is from."""

from __future__ import annotations

from numbers import Integral
from typing import Any

from emulator.errors import FitError


def check_size(width: Any, height: Any) -> tuple[int, int]:
    """Refuse what is no size of a sensor; returns Python integers [px].

    Raises:
        FitError: one is no integer, or outside 1 to 32767.
    """
    for name, value in (("width", width), ("height", height)):
        whole = isinstance(value, Integral) and not isinstance(value, bool)
        if not whole or not 1 <= value <= 32767:
            raise FitError(
                f"{name} is {value!r}; allowed is a whole number of pixels from 1 to 32767; give "
                "the size of the sensor that made the recording"
            )
    return int(width), int(height)
