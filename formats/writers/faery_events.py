"""Our events as faery takes them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.events import Events

_DTYPE = np.dtype([("t", "<u8"), ("x", "<u2"), ("y", "<u2"), (("p", "on"), "?")])


def for_faery(events: Events) -> npt.NDArray[np.void]:
    """Events with unsigned numbers: the same bytes, since none is negative."""
    return np.ascontiguousarray(events).view(_DTYPE)
