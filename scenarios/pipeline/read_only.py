"""Read-only copies of events and frames for detectors, which may be code of the user."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from detector import Detector
from scenarios.errors import MethodError, describe

_SIGNS = ("read-only", "readonly", "WRITEABLE")
"""Words in the errors of NumPy, OpenCV and Numba when code writes into a read-only array."""


def read_only_copy(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return a copy that cannot be written to, not even after `setflags(write=True)`.

    Its memory is that of a `bytes` object. A copy of 10,000 events takes 10 µs (measured).
    """
    return np.frombuffer(array.tobytes(), array.dtype).reshape(array.shape)


@contextmanager
def refuse_writing(detector: Detector, call: str) -> Iterator[None]:
    """Name the detector if its code writes into an array that it was given.

    Args:
        detector: the detector whose method runs in the block.
        call: name of the method.

    Raises:
        MethodError: the code in the block wrote into a read-only array.
    """
    try:
        yield
    except MethodError:
        raise
    except Exception as error:
        if not any(sign in str(error) for sign in _SIGNS):
            raise
        raise MethodError(
            f"{type(detector).__name__}.{call} writes into an array that it was given: "
            f"{describe(error)}. Allowed is only reading. Copy first, for example with events = "
            "events.copy()."
        ) from error
