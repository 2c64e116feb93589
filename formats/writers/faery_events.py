"""Conversion of events to the dtype that faery takes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.events import Events

_DTYPE = np.dtype([("t", "<u8"), ("x", "<u2"), ("y", "<u2"), (("p", "on"), "?")])


def to_faery(events: Events) -> npt.NDArray[np.void]:
    """Return a view of events as unsigned numbers; none is negative, so the bytes are equal."""
    return np.ascontiguousarray(events).view(_DTYPE)
