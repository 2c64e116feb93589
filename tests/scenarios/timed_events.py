"""Made-up events for tests in which only the times matter."""

from typing import Any

import numpy as np

from flybench.events import EVENT_DTYPE


def events_at(*times_us: int) -> Any:
    """Return one event per time, on neighbouring pixels of one row, alternately ON and OFF."""
    events = np.zeros(len(times_us), EVENT_DTYPE)
    events["t"] = times_us
    events["x"], events["y"] = np.arange(len(times_us)) % 346, 7
    events["p"] = np.arange(len(times_us)) % 2 == 0
    return events
